// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/axis/change_point_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "host_tests/lab/identify/residual_tests/axis/axis_residual.h"
#include "host_tests/lab/identify/residual_tests/axis/intersample_hypotheses.h"
#include "host_tests/lab/identify/residual_tests/residual_test.h"

namespace m100::lab::identify {

double min_ratio_over_hypotheses(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                                 const Fit& fit, const ChangePoint& change) {
  if (!is_stick_undersampled(data)) {
    return std::numeric_limits<double>::infinity();
  }
  const std::vector<FreeParameter> free_parameters =
      free_parameters_within_row(family, fit);  // a stick held at its last row is late
  const ParameterJump jump{change.free_parameter, change.change.at_s,
                           change.after.*change.free_parameter.member - change.before.*change.free_parameter.member};
  return IntersampleHypotheses(data, ranges, family.model(fit)).min_over_all([&](const FreeRun& run) {
    const WhitenedFit without = fit_whitened(run, family.model(fit), free_parameters);
    WhitenedFit with = fit_whitened(run, change.before, free_parameters, &jump);
    WhitenedFit from_without = fit_whitened(run, without.before, free_parameters, &jump);
    if (from_without.score < with.score) {
      with = std::move(from_without);
    }
    const WhitenedFit from_with = fit_whitened(run, with.before, free_parameters);
    double ratio = std::min(without.score, from_with.score) - with.score;
    if (change.free_parameter.member ==
        &model::StickAxis::trim_counts) {  // otherwise the autoregression absorbs the step
      const Rows error = run.error(with.before, with.after, jump.at_s).array() - with.offset;
      const Ar filter = autoregression(error, run.segments());
      const auto power = [&](Rows rows) {
        run.whiten_rows(filter, rows);
        return rows.squaredNorm();
      };
      const Rows unbroken = run.error(without.before).array() - without.offset;
      ratio = std::max(ratio, whitened_rows(run.segments()) * std::log(power(unbroken) / power(error)));
    }
    return ratio;
  });
}

std::optional<Change> second_change_point(const AxisData& data, const std::vector<Range>& ranges,
                                          const AxisFamily& family, const Fit& fit, const ChangePoint& change) {
  constexpr double kBefore_s = 0.5;  // before the interval of the first change
  constexpr double kAfter_s = 1.0;
  constexpr double kMin_s = 2.5;
  constexpr double kAsMuch = 0.5;  // the end of a temporary change is about as likely as its start
  const Range before{-1e9, change.change.low_s - kBefore_s};
  const Range after{change.change.high_s + kAfter_s, 1e9};
  for (const auto& [side, model] : {std::pair{before, &change.before}, std::pair{after, &change.after}}) {
    std::vector<Range> kept;
    for (const Range& range : ranges) {
      const Range cut{std::max(range.first, side.first), std::min(range.second, side.second)};
      if (cut.second - cut.first > kMin_s) {
        kept.push_back(cut);
      }
    }
    if (kept.empty()) {
      continue;
    }
    const Fit own = family.with_parameters_of(fit, *model);
    FreeRun side_run(data, kept);
    weight_by_input_uncertainty(side_run, family.model(own));
    const ChangePoint second = change_point(side_run, family, own);
    if (second.found && second.change.likelihood_ratio > kAsMuch * change.change.likelihood_ratio) {
      return second.change;
    }
  }
  return std::nullopt;
}

std::optional<double> burst_beside(const FreeRun& run, const ChangePoint& change) {
  constexpr double kMaxShare = 0.1;
  Rows innovations = run.error(change.before, change.after, change.change.at_s);
  innovations.array() -= innovations.mean();
  run.whiten_rows(autoregression(innovations, run.segments()), innovations);
  const Bursts bursts = bursts_of(innovations, innovations.cwiseAbs(), ResidualOptions{}.burst_sigma);
  return bursts.share > kMaxShare ? std::optional(run.time_s()[bursts.largest]) : std::nullopt;
}

double price_of(std::size_t parameters, std::size_t fewer, const FreeRun& run) {
  const double more = static_cast<double>(parameters) - static_cast<double>(fewer);
  return std::max(0.0, more) * std::log(static_cast<double>(run.size()));
}

void add_rival_change(const ChangePoint& first, const FreeRun& run, ChangePoint& change) {
  if (change.found && change.change.name != first.change.name &&
      first.score < change.score + price_of(change.numbers, first.numbers, run) + kNameMargin) {
    change.change.rivals.push_back(first.change.name);
  }
}

}  // namespace m100::lab::identify
