// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/axis/axis_regressors.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

namespace m100::lab::identify {
namespace {

using logs::Signal;

template <typename Function>
std::vector<double> map(const std::vector<double>& values, Function&& function) {
  std::vector<double> out(values.size());
  std::transform(values.begin(), values.end(), out.begin(), function);
  return out;
}

std::vector<double> product(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> out(a.size());
  std::transform(a.begin(), a.end(), b.begin(), out.begin(), std::multiplies<>());
  return out;
}

/// Makes the columns of one stretch of the log.
class Stretch {
 public:
  Stretch(std::size_t begin, std::size_t end, const Thinned& rows) : begin_(begin), end_(end), rows_(rows) {}

  /// The channel delayed by each lag; lags reach into the samples before the stretch.
  RegressorGroup lagged(const std::string& source, const std::vector<double>& channel,
                        const std::vector<std::size_t>& lags) const {
    RegressorGroup group{source, {}};
    std::vector<double> column(end_ - begin_);
    for (const std::size_t lag : lags) {
      for (std::size_t i = begin_; i < end_; ++i) {
        column[i - begin_] = channel[i >= lag ? i - lag : 0];
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
  const std::vector<double>& u = signals.data.stick;
  const auto square = [](double v) { return v * std::abs(v); };
  const auto even = [](double v) { return v * v; };
  std::vector<RegressorGroup> out;
  out.push_back(stretch.lagged(signals.stick_name, u, many));
  RegressorGroup powers = stretch.lagged(signals.stick_name + " powers", map(u, square), few);
  append(powers, stretch.lagged("", map(u, even), few));
  append(powers, stretch.lagged("", map(u, [](double v) { return v * v * v; }), few));
  out.push_back(std::move(powers));
  out.push_back(stretch.lagged(signals.stick_name + " * its rate", product(u, slope(u, log.period_s)), few));
  std::vector<double> time(u.size());
  for (std::size_t i = 0; i < time.size(); ++i) {
    time[i] = log.time_s(i) - 0.5 * (log.time_s(begin) + log.time_s(end));
  }
  RegressorGroup trend = stretch.lagged("time", time, {0});
  append(trend, stretch.lagged("", map(time, even), {0}));
  out.push_back(std::move(trend));
  out.push_back(stretch.lagged(signals.stick_name + " * time", product(u, time), few));
  if (!signals.other_name.empty()) {
    const std::vector<double>& other = signals.data.other;
    RegressorGroup both = stretch.lagged(signals.other_name, other, few);
    append(both, stretch.lagged("", map(other, square), few));
    append(both, stretch.lagged("", map(other, even), few));
    out.push_back(std::move(both));
    out.push_back(stretch.lagged(signals.stick_name + " * " + signals.other_name, product(u, other), few));
  }
  for (const Signal signal : {Signal::kStickRoll, Signal::kStickPitch, Signal::kStickThrottle, Signal::kStickYaw}) {
    const std::string name(logs::name_of(signal));
    if (!log.has(signal) || name == signals.stick_name || name == signals.other_name) {
      continue;
    }
    out.push_back(stretch.lagged(name, log.of(signal), few));
    out.push_back(stretch.lagged(signals.stick_name + " * " + name, product(u, log.of(signal)), few));
  }
  for (const auto& [name, channel] : log.extra) {
    double mean = 0.0;
    for (const double value : channel) {
      mean += value / static_cast<double>(channel.size());
    }
    const std::vector<double> centred = map(channel, [mean](double v) { return v - mean; });
    RegressorGroup group = stretch.lagged(name, centred, few);
    append(group, stretch.lagged("", map(centred, even), {0}));
    out.push_back(std::move(group));
    out.push_back(stretch.lagged(signals.stick_name + " * " + name, product(u, centred), few));
  }
  return out;
}

std::vector<RegressorGroup> axis_activity(const AxisSignals& signals, std::size_t begin, std::size_t end,
                                          const Thinned& rows) {
  const Stretch stretch(begin, end, rows);
  const double period_s = signals.data.period_s;
  const auto lag = [&](double s) { return static_cast<std::size_t>(std::lround(s / period_s)); };
  const std::vector<std::size_t> lags{lag(0.0), lag(0.15), lag(0.3), lag(0.6), lag(1.0)};
  const auto size = [](double v) { return std::abs(v); };
  const std::vector<double>& u = signals.data.stick;
  RegressorGroup group = stretch.lagged(signals.stick_name + " activity", map(u, size), lags);
  append(group, stretch.lagged("", map(slope(u, period_s), size), lags));
  return {std::move(group)};
}

}  // namespace m100::lab::identify
