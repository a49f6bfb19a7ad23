// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/axis/ground_check.h"

#include <algorithm>
#include <cmath>

#include "host_tests/lab/printed.h"

namespace m100::lab::identify {
namespace {

/// A mean power, and the number of values that it is the mean of.
struct Power {
  double mean;
  double count;
};

/// Power of the model's residual on one side of a date.
Power residual_power(const Rows& error, const FreeRun& run, double date_s, bool after) {
  double sum = 0.0;
  double rows = 0.0;
  for (std::size_t row = 0; row < run.size(); ++row) {
    const double left = error(static_cast<Eigen::Index>(row));
    const bool counts = (run.time_s()[row] > date_s) == after;
    sum += counts ? left * left : 0.0;
    rows += counts ? 1.0 : 0.0;
  }
  return {sum / rows, rows};
}

/// Variance of the response about its mean in some ranges.
Power response_power(const AxisData& data, const std::vector<Range>& ranges) {
  double sum = 0.0;
  double squares = 0.0;
  double samples = 0.0;
  for (const Range& range : ranges) {
    for (std::size_t i = 0; i < data.measured.size(); ++i) {
      const bool counts = data.valid[i] != 0 && data.time_s(i) >= range.first && data.time_s(i) < range.second;
      sum += counts ? data.measured[i] : 0.0;
      squares += counts ? data.measured[i] * data.measured[i] : 0.0;
      samples += counts ? 1.0 : 0.0;
    }
  }
  return {squares / samples - (sum / samples) * (sum / samples), samples};
}

/// Whether the response is too still for flight on one side of a date: less than a fifth of the model's residual on the
/// other side (a twenty-fifth in power); the power of the same air never differs by so much over seconds.
bool is_at_rest(const AxisProblem& problem, const Request& request, const Fit& fit, double date_s, bool after) {
  constexpr double kComesToRest_s = 1.0;
  constexpr double kMin_s = 3.0;
  constexpr double kCalm = 0.2;
  const AxisData& data = problem.training().signals.data;
  const FreeRun run = problem.free_run();
  const Power flown = residual_power(run.error(problem.axis_family().model(fit)), run, date_s, !after);
  std::vector<Range> ranges = request.requested;
  for (Range& range : ranges) {
    (after ? range.first : range.second) =
        after ? std::max(range.first, date_s + kComesToRest_s) : std::min(range.second, date_s - kComesToRest_s);
  }
  const Power rested = response_power(data, ranges);
  if (rested.count * data.period_s < kMin_s || flown.count < kMin_s / run.mean_s()) {
    return false;
  }
  return rested.mean < kCalm * kCalm * flown.mean;
}

}  // namespace

std::string ground_reason(const AxisProblem& problem, const Request& request, const Fit& fit, const Change& change) {
  constexpr double kSilent = 0.15;  // of the other side's gain; less is no answer, as in ground_times
  if (change.name == "gain") {
    // A reversed response is still a response, so absolute gains are compared.
    const double before = std::abs(change.parameters.front().value);
    const double after = std::abs(change.parameters.back().value);
    const bool stops = after < before;
    if ((stops ? after / before : before / after) <= kSilent) {
      return printed(
          "the vehicle does not answer %s %s %.1f s: it is on the ground or in another mode; leave that part out",
          problem.stick_name().c_str(), stops ? "after" : "before", change.at_s);
    }
  }
  const bool after = is_at_rest(problem, request, fit, change.at_s, true);
  if (after || is_at_rest(problem, request, fit, change.at_s, false)) {
    return printed("%s is too still for flight %s %.1f s: the vehicle is on the ground; leave that part out",
                   request.axis.c_str(), after ? "after" : "before", change.at_s);
  }
  return "";
}

}  // namespace m100::lab::identify
