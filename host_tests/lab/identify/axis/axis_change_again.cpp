// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/axis/axis_change_again.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "host_tests/lab/identify/axis/axis_remainder.h"
#include "host_tests/lab/identify/axis/row_readings.h"

namespace m100::lab::identify {

double ratio_between_rows(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                          const Fit& fit, const AxisChange& change) {
  double least = std::numeric_limits<double>::infinity();
  if (!slow_rows(data)) {
    return least;
  }
  RowReadings readings = readings_of(data, ranges);
  weigh_by_what_is_known(readings.runs, data, family.model(fit));
  const std::vector<Knob> knobs = knobs_within_a_row(family, fit);  // a stick held at its last row is late
  const Break jump{change.knob, change.change.at_s,
                   change.after.*change.knob.member - change.before.*change.knob.member};
  for (const FreeRun& run : readings.runs) {
    const WhitenedFit without = fit_whitened(run, family.model(fit), knobs);
    WhitenedFit with = fit_whitened(run, change.before, knobs, &jump);
    WhitenedFit from_without = fit_whitened(run, without.before, knobs, &jump);
    if (from_without.score < with.score) {
      with = std::move(from_without);
    }
    const WhitenedFit from_with = fit_whitened(run, with.before, knobs);
    double ratio = std::min(without.score, from_with.score) - with.score;
    if (change.knob.member == &model::StickAxis::trim_counts) {  // otherwise the autoregression absorbs the step
      const Rows error = run.error(with.before, with.after, jump.at_s).array() - with.offset;
      const Ar filter = autoregression(error, run.segments());
      const auto power = [&](Rows rows) {
        run.make_white(filter, rows);
        return rows.squaredNorm();
      };
      const Rows unbroken = run.error(without.before).array() - without.offset;
      ratio = std::max(ratio, whitened_rows(run.segments()) * std::log(power(unbroken) / power(error)));
    }
    least = std::min(least, ratio);
  }
  return least;
}

std::optional<Change> another_change(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                                     const Fit& fit, const AxisChange& change) {
  constexpr double kBefore_s = 0.5;  // before the interval of the date
  constexpr double kAfter_s = 1.0;
  constexpr double kLeast_s = 2.5;
  constexpr double kAsMuch = 0.5;  // the end of a temporary change is about as likely as its start
  const Range before{-1e9, change.change.low_s - kBefore_s};
  const Range after{change.change.high_s + kAfter_s, 1e9};
  for (const auto& [side, model] : {std::pair{before, &change.before}, std::pair{after, &change.after}}) {
    std::vector<Range> kept;
    for (const Range& range : ranges) {
      const Range cut{std::max(range.first, side.first), std::min(range.second, side.second)};
      if (cut.second - cut.first > kLeast_s) {
        kept.push_back(cut);
      }
    }
    if (kept.empty()) {
      continue;
    }
    const Fit own = family.moved_to(fit, *model);
    FreeRun side_run(data, kept);
    weigh_by_what_is_known({&side_run, 1}, data, family.model(own));
    const AxisChange second = change_of(side_run, family, own);
    if (second.found && second.change.likelihood_ratio > kAsMuch * change.change.likelihood_ratio) {
      return second.change;
    }
  }
  return std::nullopt;
}

}  // namespace m100::lab::identify
