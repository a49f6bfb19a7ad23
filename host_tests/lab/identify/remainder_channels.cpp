// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/remainder_channels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace m100::lab::identify {
namespace {

using logs::Signal;

/// Channels of the log at the times of the rows, as means over a row.
class Channels {
 public:
  Channels(const logs::FlightLog& log, const RemainderInput& input) : log_(log), input_(input) {}

  std::vector<Channel> all() const {
    std::vector<Channel> out{{"time", "s", input_.t_s}};
    for (std::size_t k = 0; k <= static_cast<std::size_t>(Signal::kVelocityZ); ++k) {
      add_signal(static_cast<Signal>(k), out);
    }
    add_speeds(out);
    for (const auto& [name, values] : log_.extra) {
      out.push_back({name, "", means(values, 0.0)});
    }
    return out;
  }

 private:
  void add_signal(Signal signal, std::vector<Channel>& out) const {
    static constexpr std::array kUnits{"counts", "counts", "counts", "counts", "rad",   "rad",   "rad/s",
                                       "m/s",    "rad",    "rad",    "rad",    "rad/s", "rad/s", "rad/s",
                                       "m",      "m",      "m",      "m/s",    "m/s",   "m/s"};
    const std::string name(logs::name_of(signal));
    const bool is_in_speeds = signal == Signal::kVelocityX || signal == Signal::kVelocityY;
    if (!log_.has(signal) || name == input_.response || name == input_.rate ||
        (is_in_speeds && log_.has(Signal::kAttitudeYaw))) {
      return;
    }
    const double delay_s = signal < Signal::kAttitudeRoll ? input_.stick_delay_s : 0.0;
    out.push_back({name, kUnits[static_cast<std::size_t>(signal)], means(log_.of(signal), delay_s)});
    if (signal == Signal::kAttitudeYaw) {
      for (double& yaw : out.back().values) {
        yaw = std::remainder(yaw, 2.0 * std::numbers::pi);
      }
    }
  }

  /// Horizontal speed along and across the heading, and its size: air acts on the body.
  void add_speeds(std::vector<Channel>& out) const {
    if (!log_.has(Signal::kVelocityX) || !log_.has(Signal::kVelocityY) || !log_.has(Signal::kAttitudeYaw)) {
      return;
    }
    const std::vector<double> x = means(log_.of(Signal::kVelocityX), 0.0);
    const std::vector<double> y = means(log_.of(Signal::kVelocityY), 0.0);
    const std::vector<double> yaw = means(log_.of(Signal::kAttitudeYaw), 0.0);
    Channel ahead{"speed ahead", "m/s", x}, left{"speed to the left", "m/s", x}, size{"horizontal speed", "m/s", x};
    for (std::size_t i = 0; i < x.size(); ++i) {
      ahead.values[i] = x[i] * std::cos(yaw[i]) + y[i] * std::sin(yaw[i]);
      left.values[i] = y[i] * std::cos(yaw[i]) - x[i] * std::sin(yaw[i]);
      size.values[i] = std::hypot(x[i], y[i]);
    }
    for (Channel* one : {&ahead, &left, &size}) {
      out.push_back(std::move(*one));
    }
  }

  std::vector<double> means(const std::vector<double>& samples, double earlier_s) const {
    std::vector<double> out;
    const double half_s = 0.5 * (input_.row_s - log_.period_s);
    for (const double t_s : input_.t_s) {
      const auto at = [&](double time_s) {
        const double index = std::round((time_s - earlier_s - log_.start_s) / log_.period_s);
        return static_cast<std::size_t>(std::clamp(index, 0.0, static_cast<double>(samples.size() - 1)));
      };
      const std::size_t first = at(t_s - half_s);
      const std::size_t last = std::max(first, at(t_s + half_s));
      double sum = 0.0;
      for (std::size_t i = first; i <= last; ++i) {
        sum += samples[i];
      }
      out.push_back(sum / static_cast<double>(last - first + 1));
    }
    return out;
  }

  const logs::FlightLog& log_;
  const RemainderInput& input_;
};

}  // namespace

std::vector<Channel> channels_of(const logs::FlightLog& log, const RemainderInput& input) {
  return Channels(log, input).all();
}

}  // namespace m100::lab::identify
