// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/axis/axis_rest.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace m100::lab::identify {
namespace {

/// Whether the response rests on one side of a date, as no air lets it: less than a fifth of what the model leaves of
/// the other side, a twenty-fifth in power, which two samples of one air never are over seconds.
bool stands(const AxisStudy& study, const Request& request, const Fit& fit, double date_s, bool after) {
  constexpr double kComesToRest_s = 1.0;
  constexpr double kLeast_s = 3.0;
  constexpr double kCalm = 0.2;
  const AxisData& data = study.training().signals.data;
  const FreeRun run = study.free_run();
  const Rows error = run.error(study.axis_family().model(fit));
  double flown = 0.0;
  double flown_rows = 0.0;
  for (std::size_t row = 0; row < run.size(); ++row) {
    const bool other_side = (run.time_s()[row] > date_s) != after;
    flown += other_side ? error(static_cast<Eigen::Index>(row)) * error(static_cast<Eigen::Index>(row)) : 0.0;
    flown_rows += other_side ? 1.0 : 0.0;
  }
  double sum = 0.0;
  double squares = 0.0;
  double samples = 0.0;
  for (const Range& range : request.asked) {
    const double from_s = after ? std::max(range.first, date_s + kComesToRest_s) : range.first;
    const double to_s = after ? range.second : std::min(range.second, date_s - kComesToRest_s);
    for (std::size_t i = 0; i < data.measured.size(); ++i) {
      const bool counts = data.valid[i] != 0 && data.time_s(i) >= from_s && data.time_s(i) < to_s;
      sum += counts ? data.measured[i] : 0.0;
      squares += counts ? data.measured[i] * data.measured[i] : 0.0;
      samples += counts ? 1.0 : 0.0;
    }
  }
  if (samples * data.period_s < kLeast_s || flown_rows < kLeast_s / run.mean_s()) {
    return false;
  }
  const double rest = squares / samples - (sum / samples) * (sum / samples);
  return rest < kCalm * kCalm * flown / flown_rows;
}

}  // namespace

std::string no_flight_beside(const AxisStudy& study, const Request& request, const Fit& fit, const Change& change) {
  constexpr double kSilent = 0.15;  // of the other side's gain: as in ground_times, no answer
  std::array<char, 160> text{};
  if (change.name == "gain") {
    // A reversed answer is an answer: sizes are compared.
    const double before = std::abs(change.parameters.front().value);
    const double after = std::abs(change.parameters.back().value);
    const bool stops = after < before;
    if ((stops ? after / before : before / after) <= kSilent) {
      std::snprintf(text.data(), text.size(),
                    "%s is not answered %s %.1f s: on the ground, or in another mode; leave that part out",
                    study.stick_name().c_str(), stops ? "after" : "before", change.at_s);
      return text.data();
    }
  }
  const bool after = stands(study, request, fit, change.at_s, true);
  if (after || stands(study, request, fit, change.at_s, false)) {
    std::snprintf(text.data(), text.size(), "%s rests %s %.1f s as no air lets it: on the ground; leave that part out",
                  request.axis.c_str(), after ? "after" : "before", change.at_s);
  }
  return text.data();
}

}  // namespace m100::lab::identify
