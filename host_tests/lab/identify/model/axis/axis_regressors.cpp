// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/axis/axis_regressors.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace m100::lab::identify {
namespace {

using logs::Signal;

auto value_of(const std::vector<double>& channel) {
  return [&channel](std::size_t sample) { return channel[sample]; };
}

/// Makes the columns of one stretch of the log.
class Stretch {
 public:
  Stretch(std::size_t begin, std::size_t end, const Thinned& rows) : begin_(begin), end_(end), rows_(rows) {}

  /// One column of means for each lag [samples] of `channel`. A lag may reach back before the stretch.
  template <typename Channel>
  RegressorGroup lagged(const std::string& source, const Channel& channel, const std::vector<std::size_t>& lags) const {
    RegressorGroup group{source, {}};
    std::vector<double> column(end_ - begin_);
    for (const std::size_t lag : lags) {
      for (std::size_t i = begin_; i < end_; ++i) {
        column[i - begin_] = channel(i >= lag ? i - lag : 0);
      }
      const Eigen::VectorXd means = mean_of(column, rows_);
      group.columns.emplace_back(means.begin(), means.end());
    }
    return group;
  }

 private:
  std::size_t begin_;
  std::size_t end_;
  const Thinned& rows_;
};

void append(RegressorGroup& group, RegressorGroup more) {
  for (std::vector<double>& column : more.columns) {
    group.columns.push_back(std::move(column));
  }
}

}  // namespace

std::vector<RegressorGroup> axis_regressors(const logs::FlightLog& log, const AxisSignals& signals, std::size_t begin,
                                            std::size_t end, const Thinned& rows) {
  const Stretch stretch(begin, end, rows);
  const auto lag = [&](double s) { return static_cast<std::size_t>(std::lround(s / log.period_s)); };
  std::vector<std::size_t> many;
  std::vector<std::size_t> few;
  for (const double s : {0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.5, 2.0}) {
    many.push_back(lag(s));
  }
  for (const double s : {0.0, 0.1, 0.2, 0.3, 0.5, 0.8}) {
    few.push_back(lag(s));
  }
  using Sample = std::size_t;
  const auto u = value_of(signals.data.stick);
  const auto square = [](auto channel) { return [channel](Sample i) { return channel(i) * std::abs(channel(i)); }; };
  const auto even = [](auto channel) { return [channel](Sample i) { return channel(i) * channel(i); }; };
  const auto times_stick = [u](auto channel) { return [u, channel](Sample i) { return u(i) * channel(i); }; };
  std::vector<RegressorGroup> out;
  out.push_back(stretch.lagged(signals.stick_name, u, many));
  RegressorGroup powers = stretch.lagged(signals.stick_name + " powers", square(u), few);
  append(powers, stretch.lagged("", even(u), few));
  append(powers, stretch.lagged("", times_stick(even(u)), few));
  out.push_back(std::move(powers));
  const auto rate = [&](Sample i) { return central_difference(signals.data.stick, i, log.period_s); };
  out.push_back(stretch.lagged(signals.stick_name + " * its rate", times_stick(rate), few));
  const auto time = [&](Sample i) { return log.time_s(i) - 0.5 * (log.time_s(begin) + log.time_s(end)); };
  RegressorGroup trend = stretch.lagged("time", time, {0});
  append(trend, stretch.lagged("", even(time), {0}));
  out.push_back(std::move(trend));
  out.push_back(stretch.lagged(signals.stick_name + " * time", times_stick(time), few));
  if (!signals.other_name.empty()) {
    const auto other = value_of(signals.data.other);
    RegressorGroup both = stretch.lagged(signals.other_name, other, few);
    append(both, stretch.lagged("", square(other), few));
    append(both, stretch.lagged("", even(other), few));
    out.push_back(std::move(both));
    out.push_back(stretch.lagged(signals.stick_name + " * " + signals.other_name, times_stick(other), few));
  }
  for (const Signal signal : {Signal::kStickRoll, Signal::kStickPitch, Signal::kStickThrottle, Signal::kStickYaw}) {
    const std::string name(logs::name_of(signal));
    if (!log.has(signal) || name == signals.stick_name || name == signals.other_name) {
      continue;
    }
    const auto stick = value_of(log.of(signal));
    out.push_back(stretch.lagged(name, stick, few));
    out.push_back(stretch.lagged(signals.stick_name + " * " + name, times_stick(stick), few));
  }
  for (const auto& [name, channel] : log.extra) {
    double mean = 0.0;
    for (const double value : channel) {
      mean += value / static_cast<double>(channel.size());
    }
    const auto centred = [value = value_of(channel), mean](Sample i) { return value(i) - mean; };
    RegressorGroup group = stretch.lagged(name, centred, few);
    append(group, stretch.lagged("", even(centred), {0}));
    out.push_back(std::move(group));
    out.push_back(stretch.lagged(signals.stick_name + " * " + name, times_stick(centred), few));
  }
  return out;
}

std::vector<RegressorGroup> axis_activity(const AxisSignals& signals, std::size_t begin, std::size_t end,
                                          const Thinned& rows) {
  const Stretch stretch(begin, end, rows);
  const double period_s = signals.data.period_s;
  const auto lag = [&](double s) { return static_cast<std::size_t>(std::lround(s / period_s)); };
  const std::vector<std::size_t> lags{lag(0.0), lag(0.15), lag(0.3), lag(0.6), lag(1.0)};
  const std::vector<double>& stick = signals.data.stick;
  const auto size = [&](std::size_t i) { return std::abs(stick[i]); };
  const auto speed = [&](std::size_t i) { return std::abs(central_difference(stick, i, period_s)); };
  RegressorGroup group = stretch.lagged(signals.stick_name + " activity", size, lags);
  append(group, stretch.lagged("", speed, lags));
  return {std::move(group)};
}

}  // namespace m100::lab::identify
