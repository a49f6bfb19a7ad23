// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/axis/intersample_hypotheses.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "firmware/sysid/axis_dynamics.h"
#include "host_tests/lab/identify/model/whitening.h"
#include "host_tests/lab/identify/residual_tests/axis/axis_change_point.h"

namespace m100::lab::identify {

IntersampleHypotheses::IntersampleHypotheses(const AxisData& data, const std::vector<Range>& ranges,
                                             const model::StickAxis& model)
    : ranges_(ranges), as_logged_(data, ranges) {
  weight_by_input_uncertainty(as_logged_, model);
}

bool sharpens_rows(const AxisData& data, const model::StickAxis& model) {
  return is_stick_undersampled(data) && model.lead_zero_s > 0.0 && model.lead_zero_s < 0.5 * data.stick_row_s;
}

double step_time_error_s(const AxisData& data, double from_s, double to_s) {
  if (!is_stick_undersampled(data)) {
    return 0.0;
  }
  const auto row = static_cast<std::size_t>(std::lround(data.stick_row_s / data.period_s));
  double squares = 0.0;
  double fourths = 0.0;
  for (std::size_t i = 0; i + row < data.stick.size(); i += row) {
    const double way = data.time_s(i) > from_s && data.time_s(i) <= to_s ? data.stick[i + row] - data.stick[i] : 0.0;
    squares += way * way;
    fourths += way * way * way * way;
  }
  return data.stick_row_s * std::sqrt(fourths / std::max(1e-300, 12.0 * squares * squares));
}

namespace {

/// Means over `mean` samples of the response to one count for one sample, whitened: the effect on the innovations of a
/// stick that moved earlier or later than logged.
std::vector<double> step_time_innovations(const AxisData& data, std::size_t mean, const model::StickAxis& model,
                                          const Ar& filter) {
  constexpr double kLasts_s = 1.5;
  const auto means = static_cast<std::size_t>(std::lround(kLasts_s / data.period_s)) / mean;
  sysid::AxisDynamics<double> dynamics(model, data.period_s);
  dynamics.start(0.0, 0.0);
  const auto delay = static_cast<std::size_t>(std::lround(std::max(0.0, model.transport_delay_s) / data.period_s));
  const double lead = model.lead_zero_s / data.period_s;
  std::vector<double> out(means, 0.0);
  for (std::size_t i = 0; i < means * mean; ++i) {
    out[i / mean] += dynamics.value() / static_cast<double>(mean);
    const double now = i == delay ? 1.0 + lead : i == delay + 1 ? -lead : 0.0;
    dynamics.step(model.scale_per_count * now);
  }
  for (std::size_t k = means; k-- > 0;) {
    for (std::size_t lag = 1; lag <= std::min<std::size_t>(k, kArOrder); ++lag) {
      out[k] -= filter(static_cast<Eigen::Index>(lag) - 1) * out[k - lag];
    }
  }
  return out;
}

/// Variance of each innovation if every step of the stick between two rows happened at one moment of the row, uniformly
/// distributed: (step times row) squared over twelve.
Rows step_time_variance(const FreeRun& run, const model::StickAxis& model, const Ar& filter) {
  const AxisData& data = run.data();
  const auto row = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(data.stick_row_s / data.period_s)));
  const double row_in_samples = std::min(static_cast<double>(row), data.logged_stick_row_s() / data.period_s);
  const std::size_t mean = run.mean();
  std::vector<double> areas(data.stick.size() / mean + 1, 0.0);
  for (std::size_t i = 0; i + row < data.stick.size(); i += row) {
    const double area = (data.stick[i + row] - data.stick[i]) * row_in_samples;
    areas[(i + row / 2) / mean] += area * area / 12.0;
  }
  const std::vector<double> kernel = step_time_innovations(data, mean, model, filter);
  Rows out = Rows::Zero(static_cast<Eigen::Index>(run.size()));
  for (std::size_t k = 0; k < run.size(); ++k) {
    const auto at = static_cast<std::size_t>(std::max(0.0, (run.time_s()[k] - data.start_s) / data.period_s)) / mean;
    for (std::size_t lag = 0; lag < kernel.size() && lag <= at; ++lag) {
      out(static_cast<Eigen::Index>(k)) += areas[at - lag] * kernel[lag] * kernel[lag];
    }
  }
  return out;
}

/// How much of step_time_variance() the innovations contain, by maximum likelihood, over the variance of the air. It is
/// zero if the stick moves smoothly, because slow samples determine such a stick. The limit of 3 is a step at an end of
/// the row.
double step_time_share(const Rows& white, const Rows& moments, double power) {
  constexpr double kMax = 3.0;
  constexpr int kSteps = 24;
  double best = 0.0;
  double minimum = std::numeric_limits<double>::infinity();
  for (int step = 0; step <= kSteps; ++step) {
    const double share = step == 0 ? 0.0 : kMax * std::pow(0.75, kSteps - step);
    // The estimated power of the air decreases as the share increases: a few fixed-point iterations.
    double air = power;
    for (int round = 0; round < 4; ++round) {
      air = (white.array().square() / (1.0 + share * moments.array() / air)).mean();
    }
    const double cost =
        (white.array().square() / (air + share * moments.array()) + (air + share * moments.array()).log()).sum();
    best = cost < minimum ? share / air : best;
    minimum = std::min(minimum, cost);
  }
  return best;
}

}  // namespace

std::vector<FreeParameter> free_parameters_within_row(const AxisFamily& family, const Fit& fit) {
  std::vector<FreeParameter> out = free_parameters_of(family, fit);
  for (FreeParameter& free_parameter : out) {
    if (free_parameter.member == &model::StickAxis::transport_delay_s) {
      free_parameter.low = std::min(free_parameter.low, -std::max(family.period_s(), family.stick_row_s()));
    }
  }
  return out;
}

void weight_by_input_uncertainty(FreeRun& run, const model::StickAxis& model) {
  const Rows error = run.error(model);
  const std::vector<Segment>& segments = run.segments();
  const Ar filter = autoregression(error, segments);
  Rows white = error;
  whiten(filter, segments, white);
  const double power = white.squaredNorm() / std::max(1.0, whitened_rows(segments));
  if (!(power > 0.0)) {
    return;
  }
  const Rows moments = step_time_variance(run, model, filter);
  run.set_weights((1.0 + step_time_share(white, moments, power) * moments.array()).rsqrt());
}

double min_ratio_over_hypotheses(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                                 const Fit& fit, const std::string& effect) {
  const Structure reduced = family.without(fit.structure, effect);
  // A trim is not tested: no unknown time of a step looks like a trim, and a whitened fit has a free offset.
  if (reduced == fit.structure || effect == "trim_offset") {
    return std::numeric_limits<double>::infinity();
  }
  const Fit plain = family.fit(reduced, std::vector<int>(family.block_count(), 1), &fit);
  return IntersampleHypotheses(data, ranges, family.model(fit)).min_over_all([&](const FreeRun& run) {
    const WhitenedFit with = fit_whitened(run, family.model(fit), free_parameters_within_row(family, fit));
    double without = std::numeric_limits<double>::infinity();
    for (const Fit& start : {plain, family.with_parameters_of(plain, with.before)}) {
      without =
          std::min(without, fit_whitened(run, family.model(start), free_parameters_within_row(family, start)).score);
    }
    return without - with.score;
  });
}

}  // namespace m100::lab::identify
