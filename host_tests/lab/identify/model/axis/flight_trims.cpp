// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/axis/flight_trims.h"
#include "host_tests/lab/printed.h"

#include <algorithm>
#include <cmath>

namespace m100::lab::identify {
namespace {

constexpr double kMinCounts = 6.0;  // smallest significant trim
constexpr double kStandardErrors = 4.0;
constexpr double kWidest = 0.4;  // largest trim scanned, in 98 % quantiles of the stick

/// Blocks of one flight, and their errors with a trim of this flight.
class FlightTrimFit {
 public:
  FlightTrimFit(const AxisDataSet& part, std::size_t flight, const model::StickAxis& axis)
      : part_(part), axis_(axis), weights_(part.blocks.size(), 0) {
    const AxisData& data = part.signals.data;
    for (std::size_t block = 0; block < weights_.size(); ++block) {
      const std::size_t begin = part.blocks[block].begin;
      const auto own = static_cast<std::size_t>(
          std::count_if(data.flights.begin(), data.flights.end(), [&](std::size_t at) { return at <= begin; }));
      weights_[block] = own == flight + 1 ? 1 : 0;
      blocks_ += weights_[block] > 0 ? 1U : 0U;
    }
  }

  std::size_t blocks() const { return blocks_; }

  std::vector<double> error(double trim) const {
    model::StickAxis moved = axis_;
    moved.trim_counts += trim;
    std::vector<double> out(part_.blocks.samples());
    out.resize(part_.blocks.error(moved, weights_, out));
    return out;
  }

  double power(double trim) const {
    double sum = 0.0;
    for (const double value : error(trim)) {
      sum += value * value;
    }
    return sum;
  }

  /// The trim with the smallest error. A coarse scan comes first, because a dead zone causes local minima.
  double best(double widest, double min_step) const {
    constexpr int kSteps = 10;
    double found = 0.0;
    double minimum = power(0.0);
    double step = widest / kSteps;
    const auto take = [&](double trim) {
      const double now = power(trim);
      if (now < minimum) {
        minimum = now;
        found = trim;
      }
    };
    for (int k = -kSteps; k <= kSteps; ++k) {
      take(k * step);
    }
    while (step > min_step) {
      step *= 0.5;
      const double centre = found;
      take(centre - step);
      take(centre + step);
    }
    return found;
  }

  /// Standard error of the trim. Different blocks count as independent, samples of one block do not.
  double sigma(double trim, double step) const {
    const std::vector<double> error_here = error(trim);
    const std::vector<double> error_there = error(trim + step);
    double curvature = 0.0;
    double squares = 0.0;
    std::size_t at = 0;
    for (std::size_t block = 0; block < weights_.size(); ++block) {
      if (weights_[block] == 0) {
        continue;
      }
      double gradient = 0.0;
      for (std::size_t i = part_.blocks[block].begin; i < part_.blocks[block].end; ++i, ++at) {
        const double slope = (error_there[at] - error_here[at]) / step;
        gradient += slope * error_here[at];
        curvature += slope * slope;
      }
      squares += gradient * gradient;
    }
    const double n = static_cast<double>(blocks_);
    return curvature > 0.0 && n > 1.0 ? std::sqrt(squares * n / (n - 1.0)) / curvature : 0.0;
  }

 private:
  const AxisDataSet& part_;
  const model::StickAxis& axis_;
  std::vector<int> weights_;
  std::size_t blocks_ = 0;
};

}  // namespace

std::vector<FlightTrim> flight_trims(const AxisProblem& problem, const Fit& fit) {
  const std::size_t flights = problem.training().signals.data.flights.size();
  std::vector<FlightTrim> out(flights);
  const AxisFamily& family = problem.axis_family();
  const model::StickAxis axis = family.model(fit);
  const double count = family.scale().minimum_counts;
  double count_known = 0.0;
  double sum = 0.0;
  for (std::size_t k = 0; k < flights; ++k) {
    const FlightTrimFit flight(problem.training(), k, axis);
    if (flight.blocks() < 2) {
      continue;
    }
    const double trim = flight.best(kWidest * family.scale().stick, 0.25 * count);
    const double sigma = std::max(flight.sigma(trim, count), 0.1 * count);
    out[k] = {{trim, trim - 1.96 * sigma, trim + 1.96 * sigma}, true};
    count_known += 1.0;
    sum += trim;
  }
  for (FlightTrim& trim : out) {
    if (trim.known) {
      const double centre = sum / count_known;
      trim.size = {trim.size.value - centre, trim.size.low - centre, trim.size.high - centre};
    }
  }
  return out;
}

bool are_distinct(const AxisProblem& problem, const std::vector<FlightTrim>& trims) {
  const double minimum = kMinCounts * problem.axis_family().scale().minimum_counts;
  return std::any_of(trims.begin(), trims.end(), [&](const FlightTrim& trim) {
    const double sigma = (trim.size.high - trim.size.low) / (2.0 * 1.96);
    return trim.known && std::abs(trim.size.value) > std::max(minimum, kStandardErrors * sigma);
  });
}

bool moved(const AxisProblem& problem, const std::vector<FlightTrim>& more) {
  const double minimum = problem.axis_family().scale().minimum_counts;
  return std::any_of(more.begin(), more.end(), [&](const FlightTrim& trim) {
    const double sigma = (trim.size.high - trim.size.low) / (2.0 * 1.96);
    return trim.known && std::abs(trim.size.value) > std::max(minimum, 0.5 * sigma);
  });
}

std::string describe(const std::vector<FlightTrim>& trims) {
  std::string out = "each flight has a trim of its own; deviations from the mean trim [counts]:";
  for (std::size_t k = 0; k < trims.size(); ++k) {
    out += trims[k].known ? printed("%s log %zu %+.4g [%.4g, %.4g]", k > 0 ? "," : "", k + 1, trims[k].size.value,
                                    trims[k].size.low, trims[k].size.high)
                          : "";
  }
  return out;
}

}  // namespace m100::lab::identify
