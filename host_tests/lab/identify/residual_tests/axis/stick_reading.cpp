// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/axis/stick_reading.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "host_tests/lab/identify/data/axis_signals.h"
#include "host_tests/lab/identify/model/axis/free_run.h"
#include "host_tests/lab/identify/residual_tests/axis/axis_change_point.h"
#include "host_tests/lab/identify/residual_tests/axis/axis_residual.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::identify {
namespace {

constexpr double kHalf_s = 60.0;  ///< of the middle of a log, in which what costs most is looked at

/// The ranges within `half_s` of their middle.
std::vector<Range> middle_of(std::vector<Range> ranges, double half_s) {
  std::sort(ranges.begin(), ranges.end());
  const double middle_s = 0.5 * (ranges.front().first + ranges.back().second);
  std::vector<Range> out;
  for (const Range& range : ranges) {
    const Range cut{std::max(range.first, middle_s - half_s), std::min(range.second, middle_s + half_s)};
    if (cut.first < cut.second) {
      out.push_back(cut);
    }
  }
  return out;
}

/// Two or more equal samples of the stick: [begin, end). Between two rests a sample may lie between their values, where
/// rows and samples are not in step.
struct Rest {
  std::size_t begin;
  std::size_t end;
};

/// The rests that begin in the ranges.
std::vector<Rest> rests_of(const AxisData& data, const std::vector<Range>& ranges) {
  std::vector<Rest> out;
  for (std::size_t i = 1; i < data.stick.size(); ++i) {
    if (data.stick[i] != data.stick[i - 1]) {
      continue;
    }
    if (!out.empty() && out.back().end == i) {
      ++out.back().end;
    } else if (std::any_of(ranges.begin(), ranges.end(), [at_s = data.time_s(i)](const Range& range) {
                 return range.first <= at_s && at_s <= range.second;
               })) {
      out.push_back({i - 1, i + 1});
    }
  }
  return out;
}

/// The likelihood of a stick that was rounded to levels: each rest on a level then hides an error of its own, uniform
/// within half a level, here normal with the same variance (linear Gaussian model: Bishop, Pattern Recognition, 3.5).
class RoundedStick {
 public:
  /// @param rests  of the stick, on levels
  RoundedStick(const AxisData& data, const std::vector<Range>& ranges, const model::StickAxis& axis,
               const std::vector<Rest>& rests, double level)
      : run_(data, ranges), error_(run_.error(axis)) {
    constexpr std::size_t kMaxRests = 300;
    const std::size_t size = std::min(rests.size(), kMaxRests);
    answers_.resize(error_.size(), static_cast<Eigen::Index>(size));
    AxisData moved = data;
    for (std::size_t k = 0; k < size; ++k) {
      const auto add = [&](double counts) {
        for (std::size_t i = rests[k].begin; i < rests[k].end; ++i) {
          moved.stick[i] = data.stick[i] + counts;
        }
      };
      add(level / std::sqrt(12.0));
      answers_.col(static_cast<Eigen::Index>(k)) = FreeRun(moved, ranges).error(axis) - error_;
      add(0.0);
    }
    error_.array() -= error_.mean();
  }

  /// By how much rounding lowers n ln(mean square of the innovations), after the price of what it leaves open.
  double evidence() const {
    constexpr int kIterations = 4;
    Rows hidden = Rows::Zero(answers_.cols());
    double best = run_.score(error_);
    const double logged = best;
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      const Rows left = error_ + answers_ * hidden;
      const Ar filter = autoregression(left, run_.segments());
      const double count = whitened_rows(run_.segments());
      const double variance = whitened(filter, left).squaredNorm() / count;
      const Rows error = whitened(filter, error_);
      Columns answers = answers_;
      for (Eigen::Index k = 0; k < answers.cols(); ++k) {
        answers.col(k) = whitened(filter, answers_.col(k));
      }
      Columns normal = answers.transpose() * answers / variance;
      normal.diagonal().array() += 1.0;
      const Eigen::LLT<Columns> solver(normal);
      const Rows right = answers.transpose() * error / variance;
      hidden = -solver.solve(right);
      const double log_determinant = 2.0 * Rows(Columns(solver.matrixL()).diagonal()).array().log().sum();
      best = std::min(best, count * std::log(variance) - count + error.squaredNorm() / variance + right.dot(hidden) +
                                log_determinant);
    }
    return logged - best;
  }

 private:
  Rows whitened(const Ar& filter, Rows values) const {
    run_.whiten_rows(filter, values);
    return values;
  }

  FreeRun run_;
  Rows error_;       ///< simulated minus measured
  Columns answers_;  ///< of each rest, to one standard deviation of the rounding
};

/// A line through the values that begin a rest. A value is held for `held` samples at most; what stays longer has not
/// moved.
AxisData through_new_values(AxisData data, const std::vector<Rest>& rests, std::size_t held) {
  for (std::size_t k = 1; k < rests.size(); ++k) {
    const std::size_t to = rests[k].begin;
    const std::size_t from = to - std::min(to - rests[k - 1].begin, held);
    const double before = data.stick[from];
    const double after = data.stick[to];
    for (std::size_t i = from; i < to; ++i) {
      data.stick[i] = std::lerp(before, after, static_cast<double>(i - from) / static_cast<double>(to - from));
    }
  }
  return data;
}

/// The distance of two levels, if 19 of 20 rests lie on levels; else 0. The others may be samples between two rows.
double level_of(const std::vector<double>& stick, const std::vector<Rest>& rests) {
  constexpr double kEqual = 1e-6;
  constexpr std::ptrdiff_t kShare = 20;
  std::vector<double> values;
  std::vector<double> changes;
  for (const Rest& rest : rests) {
    const double change = values.empty() ? 0.0 : std::abs(stick[rest.begin] - values.back());
    values.push_back(stick[rest.begin]);
    if (change > 0.0) {
      changes.push_back(change);
    }
  }
  if (changes.empty()) {
    return 0.0;
  }
  const auto small = changes.begin() + std::ssize(changes) / kShare;
  std::nth_element(changes.begin(), small, changes.end());
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  const auto on_levels = std::count_if(values.begin(), values.end(), [&](double value) {
    const double levels = (value - *middle) / *small;
    return std::abs(levels - std::round(levels)) < kEqual * (1.0 + std::abs(levels));
  });
  return kShare * (std::ssize(values) - on_levels) <= std::ssize(values) ? *small : 0.0;
}

/// Squared errors of a model in windows of the log, for delays that are longer or shorter by whole steps.
class DelayProfile {
 public:
  static constexpr double kStep_s = 0.01;

  /// @param reach  the largest number of steps, longer and shorter
  DelayProfile(const FreeRun& run, const model::StickAxis& model, int reach) : reach_(reach) {
    const std::vector<double>& time_s = run.time_s();
    begin_s_ = time_s.front();
    const auto windows = static_cast<std::size_t>((time_s.back() - begin_s_) / kWindow_s) + 1;
    for (int k = -reach; k <= reach; ++k) {
      model::StickAxis moved = model;
      moved.transport_delay_s += kStep_s * k;
      const Rows error = run.error(moved);
      std::vector<double>& squares = squares_.emplace_back(windows, 0.0);
      for (std::size_t i = 0; i < time_s.size(); ++i) {
        const double one = error(static_cast<Eigen::Index>(i));
        squares[static_cast<std::size_t>((time_s[i] - begin_s_) / kWindow_s)] += one * one;
      }
    }
  }
  /// The least sum of squares of a delay that grows steadily, by `steps` from the middle of the log to its end.
  double best(int steps) const {
    double least = std::numeric_limits<double>::infinity();
    for (int offset = -reach_ + std::abs(steps); offset <= reach_ - std::abs(steps); ++offset) {
      double sum = 0.0;
      const auto windows = static_cast<double>(squares_.front().size());
      for (std::size_t w = 0; w < squares_.front().size(); ++w) {
        const double from_middle = (2.0 * static_cast<double>(w) + 1.0 - windows) / windows;
        const auto at = static_cast<int>(std::lround(from_middle * steps)) + offset + reach_;
        sum += squares_[static_cast<std::size_t>(at)][w];
      }
      least = std::min(least, sum);
    }
    return least;
  }

 private:
  static constexpr double kWindow_s = 2.0;
  int reach_;
  double begin_s_ = 0.0;
  std::vector<std::vector<double>> squares_;  ///< of each delay, window by window
};

}  // namespace

std::string coarse_stick(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                         const Fit& fit) {
  const std::vector<Rest> rests = rests_of(data, middle_of(ranges, kHalf_s));
  constexpr std::size_t kEnough = 20;
  if (is_stick_undersampled(data) || rests.size() < kEnough) {
    return "";
  }
  std::vector<std::size_t> held;
  for (std::size_t k = 1; k < rests.size(); ++k) {
    held.push_back(rests[k].begin - rests[k - 1].begin);
  }
  const auto middle = held.begin() + std::ssize(held) / 2;
  std::nth_element(held.begin(), middle, held.end());
  const FreeRun run(data, ranges);
  const WhitenedFit unchanged = unchanged_fit(run, family, fit);
  const double by_time =
      *middle > 1 ? unchanged.score -
                        unchanged_fit(FreeRun(through_new_values(data, rests, *middle), ranges), family, fit).score
                  : 0.0;
  const double level = level_of(data.stick, rests);
  const double by_level =
      level > 0.0 ? RoundedStick(data, middle_of(ranges, kHalf_s), unchanged.before, rests, level).evidence() : 0.0;
  if (std::max(by_time, by_level) < kChanceChange) {
    return "";
  }
  const bool is_held = by_time >= by_level;
  return (is_held ? printed(" is logged anew every %.2g s only", static_cast<double>(*middle) * data.period_s)
                  : printed(" is logged in steps of %.3g counts only", level)) +
         printed(", but the response follows a smoother motion: what is %s cannot be told",
                 is_held ? "shorter" : "finer");
}

std::optional<ClockRate> clock_rate(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                                    const Fit& fit) {
  constexpr double kFastest = 0.012;
  constexpr double kMin_s = 20.0;
  const std::vector<Range> middle = middle_of(ranges, kHalf_s);
  const FreeRun run(data, middle);
  if (data.flights.size() > 1 || run.seconds() < kMin_s) {
    return std::nullopt;
  }
  const double half_s = 0.5 * (run.time_s().back() - run.time_s().front());
  const auto most = static_cast<int>(std::ceil(kFastest * half_s / DelayProfile::kStep_s));
  const DelayProfile profile(run, family.model(fit), most + 5);
  int found = 0;
  for (int steps = -most; steps <= most; ++steps) {
    found = profile.best(steps) < profile.best(found) ? steps : found;
  }
  // A delay that grows means sticks that are logged earlier and earlier: they must be read back in time.
  const double step = DelayProfile::kStep_s / half_s;
  std::vector<FreeParameter> free_parameters = free_parameters_of(family, fit);
  for (FreeParameter& one : free_parameters) {  // clocks that agree at the start do not agree in the middle
    one.low = one.member == &model::StickAxis::transport_delay_s ? -kFastest * half_s : one.low;
  }
  const auto score_at = [&](double rate) {
    AxisData moved = data;
    read_at_times(moved.stick, 0.0, rate);
    read_at_times(moved.other, 0.0, rate);
    return fit_to_convergence(FreeRun(moved, middle), family.model(fit), free_parameters).score;
  };
  const double none = score_at(0.0);
  double rate = -step * found;
  double sigma = step;
  double score = score_at(rate);
  for (int pass = 0; pass < 3; ++pass) {  // to the vertex of the parabola through three scores
    const double before = score_at(rate - sigma);
    const double after = score_at(rate + sigma);
    const double bend = before - 2.0 * score + after;
    if (!(bend > 0.0)) {
      break;
    }
    rate += sigma * std::clamp(0.5 * (before - after) / bend, -1.0, 1.0);
    sigma = std::clamp(sigma * std::sqrt(2.0 / bend), 0.05 * step, step);
    score = score_at(rate);
  }
  // The delays of the two halves differ by rate * half_s; a smaller difference is one of healthy delays or of rows.
  const double least_s = std::max(kMinDelayChange_s, 0.5 * family.stick_row_s());
  if (none - score < kChanceChange || std::abs(rate) * half_s < least_s + 2.0 * sigma * half_s) {
    return std::nullopt;
  }
  const ChangePoint change = change_point(run, family, fit);
  return change.found && change.score + kChanceChange < score ? std::nullopt : std::optional(ClockRate{rate, sigma});
}

std::string describe(const ClockRate& clock) {
  return printed(
      "the clock of the sticks runs %.2f %% (+-%.2f) %s than that of the response: the sticks were read by the other "
      "clock",
      100.0 * std::abs(clock.rate), 200.0 * clock.sigma, clock.rate < 0.0 ? "slower" : "faster");
}

}  // namespace m100::lab::identify
