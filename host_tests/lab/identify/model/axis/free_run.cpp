// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/axis/free_run.h"

#include <algorithm>
#include <cmath>

#include "firmware/sysid/axis_dynamics.h"

namespace m100::lab::identify {
namespace {

constexpr double kLookAhead_s = 0.3;  // of the stick, for delays below zero

/// Writes means of a fixed number of values, one row after the other.
class MeanRows {
 public:
  MeanRows(std::size_t values, Rows& out) : values_(values), out_(out) {}
  /// Discards an incomplete mean.
  void reset() {
    sum_ = 0.0;
    counted_ = 0;
  }
  void add(double value) {
    sum_ += value;
    if (++counted_ == values_) {
      out_(row_++) = sum_ / static_cast<double>(values_);
      reset();
    }
  }

 private:
  std::size_t values_;
  Rows& out_;
  Eigen::Index row_ = 0;
  double sum_ = 0.0;
  std::size_t counted_ = 0;
};

std::vector<Range> joined(std::vector<Range> ranges, double period_s) {
  std::sort(ranges.begin(), ranges.end());
  std::vector<Range> out;
  for (const Range& range : ranges) {
    if (!out.empty() && range.first <= out.back().second + 1.5 * period_s) {
      out.back().second = std::max(out.back().second, range.second);
    } else {
      out.push_back(range);
    }
  }
  return out;
}

}  // namespace

FreeRun::FreeRun(const AxisData& data, const std::vector<Range>& ranges)
    : data_(data),
      mean_(std::max<std::size_t>(
          1, static_cast<std::size_t>(std::lround(std::max(kMinMean_s, data.row_s) / data.period_s)))),
      settle_(static_cast<std::size_t>(std::lround(kSettle_s / data.period_s))) {
  const double whole_s = static_cast<double>(data.measured.size() + 1) * data.period_s;
  const auto past = static_cast<std::size_t>(std::lround(AxisBlocks::kPast_s / data.period_s));
  const auto ahead = static_cast<std::size_t>(std::lround(kLookAhead_s / data.period_s));
  const AxisBlocks blocks(data, joined(ranges, data.period_s), whole_s);
  for (std::size_t number = 0; number < blocks.size(); ++number) {
    const AxisBlocks::Block& block = blocks[number];
    const auto first = static_cast<Eigen::Index>(time_s_.size());
    for (std::size_t i = block.begin + settle_; i + mean_ <= block.end; i += mean_) {
      time_s_.push_back(data.time_s(i) + 0.5 * static_cast<double>(mean_ - 1) * data.period_s);
    }
    const auto last = static_cast<Eigen::Index>(time_s_.size());
    if (last > first) {
      segments_.push_back({first, last});
      runs_.push_back({block.begin, block.end, block.value, block.rate_per_s});
      commands_.add(
          {block.begin > past ? block.begin - past : 0, block.begin, std::min(block.end + ahead, data.stick.size())});
    }
  }
}

std::size_t FreeRun::arrive(const model::StickAxis& before, const model::StickAxis& after, double switch_s,
                            std::size_t number, std::vector<double>& out) const {
  const Run& run = runs_[number];
  const std::size_t past = commands_[number].past;
  const std::vector<double>* commands = &commands_.of(data_, before, number);
  std::size_t turn = run.end;
  std::vector<double> switched;
  if (data_.time_s(run.end) > switch_s) {
    const std::vector<double>& later = commands_.of(data_, after, number);
    switched = *commands;
    for (std::size_t k = 0; k < later.size(); ++k) {
      if (data_.time_s(past + k) > switch_s) {
        switched[k] = later[k];
        turn = std::min(turn, std::max(run.begin, past + k));
      }
    }
    commands = &switched;
  }
  out.resize(run.end - run.begin);
  const std::span<double> arrived(out);
  arrived_commands(*commands, before, data_.period_s, run.begin - past, arrived.first(turn - run.begin));
  arrived_commands(*commands, after, data_.period_s, turn - past, arrived.subspan(turn - run.begin));
  return turn;
}

Rows FreeRun::error(const model::StickAxis& before, const model::StickAxis& after, double switch_s) const {
  Rows out(static_cast<Eigen::Index>(size()));
  MeanRows means(mean_, out);
  std::vector<double> arrived;
  for (std::size_t number = 0; number < runs_.size(); ++number) {
    const Run& run = runs_[number];
    const std::size_t turn = arrive(before, after, switch_s, number, arrived);
    sysid::AxisDynamics<double> dynamics(before, data_.period_s);
    dynamics.start(run.value, run.rate_per_s);
    means.reset();
    for (std::size_t i = run.begin; i < run.end; ++i) {
      if (i == turn) {
        const sysid::AxisDynamics<double> left = dynamics;
        dynamics = {after, data_.period_s};
        dynamics.start(left.value(), left.rate_per_s());
      }
      if (i >= run.begin + settle_) {
        means.add(dynamics.value() - data_.measured[i]);
      }
      dynamics.step(arrived[i - run.begin]);
    }
  }
  return out;
}

void FreeRun::whiten_rows(const Ar& filter, Eigen::Ref<Rows> values) const {
  whiten(filter, segments_, values);
  if (weights_.size() == values.size()) {
    values.array() *= weights_.array();
  }
}

double FreeRun::score(const Rows& error) const {
  const double count = whitened_rows(segments_);
  Rows white = error;
  whiten_rows(autoregression(error, segments_), white);
  return count > 0.0 ? count * std::log(std::max(1e-300, white.squaredNorm() / count)) : 0.0;
}

namespace {

/// The fit of fit_whitened(), step by step. Parameters: the free ones, the size of the change, the offset.
class GaussNewton {
 public:
  GaussNewton(const FreeRun& run, const model::StickAxis& start, std::span<const FreeParameter> free_parameters,
              const ParameterJump* change)
      : run_(run), free_parameters_(free_parameters), change_(change), axis_(start) {
    for (const FreeParameter& free_parameter : free_parameters) {
      add(free_parameter, start.*free_parameter.member);
    }
    if (change != nullptr) {
      FreeParameter jump = change->free_parameter;
      const double width = jump.high - jump.low;
      jump.low = -width;
      jump.high = width;
      add(jump, change->size);
    }
    error_ = error(values_);
    offset_ = error_.mean();
    error_.array() -= offset_;
  }

  WhitenedFit run() {
    constexpr int kIterations = 10;
    constexpr double kConverged = 1e-5;
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      const double gained = step();
      if (gained < kConverged) {
        break;
      }
    }
    linearise();
    WhitenedFit out;
    const auto [before, after] = models(values_);
    out.before = before;
    out.after = after;
    out.offset = offset_;
    out.score = run_.score(error_);
    out.values.assign(values_.begin(), values_.end());
    Columns regular = normal_;  // regularised column by column, because the units differ by many powers of ten
    regular.diagonal() = regular.diagonal() * (1.0 + 1e-9) + Rows::Constant(regular.rows(), 1e-300);
    const Columns inverse = regular.ldlt().solve(Columns::Identity(regular.rows(), regular.cols()));
    const double variance =
        power_ / std::max(1.0, whitened_rows(run_.segments()) - static_cast<double>(normal_.rows()));
    for (Eigen::Index k = 0; k < values_.size(); ++k) {
      out.sigmas.push_back(std::sqrt(std::max(0.0, variance * inverse(k, k))));
    }
    return out;
  }

 private:
  void add(const FreeParameter& free_parameter, double value) {
    values_.conservativeResize(values_.size() + 1);
    values_(values_.size() - 1) = std::clamp(value, free_parameter.low, free_parameter.high);
    limits_.push_back(free_parameter);
  }

  std::pair<model::StickAxis, model::StickAxis> models(const Rows& values) const {
    model::StickAxis before = axis_;
    for (std::size_t k = 0; k < free_parameters_.size(); ++k) {
      before.*free_parameters_[k].member = values(static_cast<Eigen::Index>(k));
    }
    model::StickAxis after = before;
    if (change_ != nullptr) {
      const FreeParameter& free_parameter = change_->free_parameter;
      after.*free_parameter.member =
          std::clamp(after.*free_parameter.member + values(static_cast<Eigen::Index>(free_parameters_.size())),
                     free_parameter.low, free_parameter.high);
    }
    return {before, after};
  }

  Rows error(const Rows& values) const {
    const auto [before, after] = models(values);
    return run_.error(before, after, change_ != nullptr ? change_->at_s : 1e300);
  }

  void linearise() {
    const Ar filter = autoregression(error_, run_.segments());
    filter_ = filter;
    white_ = error_;
    run_.whiten_rows(filter, white_);
    power_ = white_.squaredNorm();
    const Eigen::Index n = values_.size();
    slopes_.resize(error_.size(), n + 1);
    for (Eigen::Index k = 0; k < n; ++k) {
      const FreeParameter& free_parameter = limits_[static_cast<std::size_t>(k)];
      Rows moved = values_;
      const double step =
          values_(k) + free_parameter.step <= free_parameter.high ? free_parameter.step : -free_parameter.step;
      moved(k) += step;
      slopes_.col(k) = (error(moved) - error_).array() - offset_;
      slopes_.col(k) /= step;
    }
    slopes_.col(n).setConstant(-1.0);
    for (Eigen::Index k = 0; k <= n; ++k) {
      run_.whiten_rows(filter, slopes_.col(k));
    }
    normal_ = slopes_.transpose() * slopes_;
  }

  /// One damped step of Gauss-Newton. @returns the share of the whitened power that it removed.
  double step() {
    linearise();
    Rows gradient = slopes_.transpose() * white_;
    for (Eigen::Index k = 0; k < values_.size(); ++k) {
      const FreeParameter& free_parameter = limits_[static_cast<std::size_t>(k)];
      const bool stuck = (values_(k) <= free_parameter.low && gradient(k) > 0.0) ||
                         (values_(k) >= free_parameter.high && gradient(k) < 0.0);
      if (stuck || !(normal_(k, k) > 0.0)) {
        gradient(k) = 0.0;
        normal_.row(k).setZero();
        normal_.col(k).setZero();
        normal_(k, k) = 1.0;
      }
    }
    double damping = 1e-4;
    for (int attempt = 0; attempt < 5; ++attempt, damping *= 12.0) {
      Columns damped = normal_;
      damped.diagonal() *= 1.0 + damping;
      const Rows move = -damped.ldlt().solve(gradient);
      Rows trial = values_ + move.head(values_.size());
      for (Eigen::Index k = 0; k < trial.size(); ++k) {
        const FreeParameter& free_parameter = limits_[static_cast<std::size_t>(k)];
        trial(k) = std::clamp(trial(k), free_parameter.low, free_parameter.high);
      }
      const double offset = offset_ + move(values_.size());
      Rows tried = error(trial).array() - offset;
      Rows white = tried;
      run_.whiten_rows(filter_, white);
      const double power = white.squaredNorm();
      if (power < power_) {
        values_ = trial;
        offset_ = offset;
        error_ = std::move(tried);
        return 1.0 - power / power_;
      }
    }
    return 0.0;
  }

  const FreeRun& run_;
  std::span<const FreeParameter> free_parameters_;
  const ParameterJump* change_;
  model::StickAxis axis_;
  std::vector<FreeParameter> limits_;
  Rows values_;
  double offset_ = 0.0;
  Rows error_;
  Ar filter_ = Ar::Zero();
  Rows white_;
  double power_ = 0.0;
  Columns slopes_;
  Columns normal_;
};

}  // namespace

WhitenedFit fit_whitened(const FreeRun& run, const model::StickAxis& start,
                         std::span<const FreeParameter> free_parameters, const ParameterJump* change) {
  return GaussNewton(run, start, free_parameters, change).run();
}

WhitenedFit fit_to_convergence(const FreeRun& run, const model::StickAxis& start,
                               std::span<const FreeParameter> free_parameters) {
  constexpr int kRounds = 4;
  constexpr double kConverged = 0.5;
  WhitenedFit out = fit_whitened(run, start, free_parameters);
  for (int round = 1; round < kRounds; ++round) {
    WhitenedFit next = fit_whitened(run, out.before, free_parameters);
    const double gained = out.score - next.score;
    out = gained > 0.0 ? std::move(next) : std::move(out);
    if (gained < kConverged) {
      break;
    }
  }
  return out;
}

}  // namespace m100::lab::identify
