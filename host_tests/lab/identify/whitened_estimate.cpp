// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/whitened_estimate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "host_tests/lab/identify/model/axis/axis_structure.h"
#include "host_tests/lab/identify/model/axis/free_run.h"
#include "host_tests/lab/identify/residual_tests/axis/axis_change_point.h"
#include "host_tests/lab/identify/selection/jackknife.h"

namespace m100::lab::identify {
namespace {

/// The fitted unit of a physical value.
double coordinate(const model::AxisNumber& number, double scale, double value) {
  return to_fitted(number, std::clamp(value / scale, number.fit.low, number.fit.high));
}

}  // namespace

std::optional<WhitenedEstimate> whitened_estimate(const AxisFamily& family, const AxisData& data,
                                                  const std::vector<Range>& ranges, const Fit& fit) {
  constexpr double kMin_s = 10.0;
  constexpr double kFewStretches = 4.0;
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const FreeRun run(data, ranges);
  if (run.seconds() < kMin_s) {
    return std::nullopt;
  }
  const std::vector<FreeParameter> free_parameters = free_parameters_of(family, fit);
  const WhitenedFit white = fit_whitened(run, family.model(fit), free_parameters, nullptr, false);
  if (white.stretches < kFewStretches) {
    return std::nullopt;
  }
  WhitenedEstimate out{family.with_parameters_of(fit, white.before), {}};
  const std::vector<AxisParameter> parameters = parameters_of(fit.structure);
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const model::AxisNumber& number = *parameters[k].number;
    Interval interval{out.fit.parameters[k], kUnknown, kUnknown};
    for (std::size_t j = 0; j < free_parameters.size(); ++j) {
      if (free_parameters[j].name == number.parameter) {
        const double scale = family.scale().of(number.unit);
        const double half_width = student_t(white.stretches - 1.0) * white.stretch_sigmas[j];
        const double a = coordinate(number, scale, white.values[j] - half_width);
        const double b = coordinate(number, scale, white.values[j] + half_width);
        interval.low = std::min(a, b);
        interval.high = std::max(a, b);
      }
    }
    out.coordinates.push_back(interval);
  }
  return out;
}

}  // namespace m100::lab::identify
