// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/alignment/capture_alignment.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host_tests/lab/logs/stream.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::logs {
namespace {

std::vector<double> slope(const std::vector<double>& values, std::size_t half, double period_s) {
  std::vector<double> out(values.size(), 0.0);
  for (std::size_t i = half; i + half < values.size(); ++i) {
    out[i] = (values[i + half] - values[i - half]) / (2.0 * static_cast<double>(half) * period_s);
  }
  return out;
}

/// Normal equations of a small time shift of the autopilot's heading, from differences over half a second.
struct Shift {
  double gradient = 0.0;   ///< product of the difference of the headings with the rate
  double curvature = 0.0;  ///< squared rate
  double count = 0.0;
};

Shift shift_between(const std::vector<double>& captured, const std::vector<double>& measured, std::size_t begin,
                    std::size_t end, double period_s) {
  const auto apart = static_cast<std::size_t>(std::lround(0.5 / period_s));
  const std::vector<double> rate = slope(measured, 1, period_s);
  Shift out;
  for (std::size_t i = begin + apart; i < end; ++i) {
    const double late = (measured[i] - captured[i]) - (measured[i - apart] - captured[i - apart]);
    const double turned = rate[i] - rate[i - apart];
    out.gradient += late * turned;
    out.curvature += turned * turned;
    out.count += 1.0;
  }
  return out;
}

}  // namespace

double capture_lag_s(const FlightLog& log, std::vector<double> captured_heading_rad, std::pair<double, double> range_s,
                     double otherwise_s) {
  constexpr int kPasses = 6;
  constexpr double kMax_s = 0.2;
  constexpr double kMinTurn_rad_s = 0.05;  // root mean square; a slower turn shows no lag
  const std::vector<double>& measured = log.of(Signal::kAttitudeYaw);
  if (captured_heading_rad.size() != measured.size() || measured.empty()) {
    return otherwise_s;
  }
  unwrap_angle(captured_heading_rad);
  const std::size_t begin = log.index_of(range_s.first);
  const std::size_t end = std::min(log.index_of(range_s.second), measured.size());
  double lag_s = 0.0;
  for (int pass = 0; pass < kPasses; ++pass) {
    const std::vector<double> late = moved_later(measured, lag_s / log.period_s);
    const Shift shift = shift_between(captured_heading_rad, late, begin, end, log.period_s);
    if (!(shift.curvature > kMinTurn_rad_s * kMinTurn_rad_s * shift.count) || std::abs(lag_s) > kMax_s) {
      return otherwise_s;
    }
    lag_s += shift.gradient / shift.curvature;
  }
  return std::abs(lag_s) > kMax_s ? otherwise_s : lag_s;
}

FlightLog with_captured_velocity(FlightLog log, double lag_s) {
  constexpr std::size_t kHalf = 5;
  log.velocity_mean_s = 2.0 * static_cast<double>(kHalf) * log.period_s;
  for (int c = 0; c < 3; ++c) {
    const std::size_t half = c == 2 ? 2 : kHalf;  // climb is fitted to its velocity, so it needs the fast details
    std::vector<double>& position = log.of(offset(Signal::kPositionX, c));
    position = moved_later(position, -lag_s / log.period_s);
    log.of(offset(Signal::kVelocityX, c)) = slope(position, half, log.period_s);
  }
  return log;
}

FlightLog with_aligned_position(FlightLog log) {
  const auto heading = log.extra.find("pose_yaw");
  if (heading == log.extra.end() || !log.has3(Signal::kPositionX) || !log.has(Signal::kAttitudeYaw)) {
    return log;
  }
  const std::pair all{log.start_s, log.time_s(log.size)};
  const double lag_s = capture_lag_s(log, heading->second, all, std::numeric_limits<double>::quiet_NaN());
  if (std::isnan(lag_s)) {
    log.notes.emplace_back(
        "the position's lag behind the attitude is unknown, because the heading hardly turned: 10 ms would move a drag "
        "by about 0.03 1/s");
    return log;
  }
  for (int c = 0; c < 3; ++c) {
    std::vector<double>& position = log.of(offset(Signal::kPositionX, c));
    position = moved_later(position, -lag_s / log.period_s);
    log.of(offset(Signal::kVelocityX, c)).clear();
  }
  log.notes.push_back(
      printed("the position lagged the attitude by %.1f ms, as the heading shows; corrected", 1e3 * lag_s));
  return log;
}

std::vector<double> moved_later(const std::vector<double>& values, double samples) {
  std::vector<double> out(values.size());
  const double last = static_cast<double>(values.size()) - 1.0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double at = std::clamp(static_cast<double>(i) - samples, 0.0, last);
    const auto below = static_cast<std::size_t>(at);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    out[i] = values[below] + (at - static_cast<double>(below)) * (values[above] - values[below]);
  }
  return out;
}

}  // namespace m100::lab::logs
