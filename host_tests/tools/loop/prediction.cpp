// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/tools/loop/prediction.h"

#include <algorithm>
#include <cmath>

#include "firmware/sysid/axis_model.h"
#include "host_tests/tools/identify/axis_blocks.h"

namespace m100::tools::loop {
namespace {

using identify::AxisData;
using logs::Signal;

AxisData axis_data(const logs::FlightLog& log, Signal stick, Signal other, Signal measured) {
  AxisData data;
  data.start_s = log.start_s;
  data.period_s = log.period_s;
  data.stick = log.of(stick);
  data.other = log.of(other);
  data.measured = log.of(measured);
  data.valid.assign(data.measured.size(), 1);
  return data;
}

std::array<double, kHorizons_s.size()> errors(const AxisData& data, double from_s, double to_s,
                                              const sysid::AxisModel<double>& model) {
  std::array<double, kHorizons_s.size()> out{};
  const auto rmse = identify::horizon_rmse(data, {{from_s, to_s}}, model, {kHorizons_s.begin(), kHorizons_s.end()});
  for (std::size_t i = 0; i < out.size() && i < rmse.size(); ++i) {
    out[i] = rmse[i].second;
  }
  return out;
}

/// Commands of one axis over the whole log, delayed.
std::vector<double> commands(const AxisData& data, const sysid::AxisModel<double>& model) {
  sysid::StaticLaw<double> law(model, data.period_s);
  std::vector<double> now(data.stick.size());
  for (std::size_t i = 0; i < now.size(); ++i) {
    now[i] = law.command(data.stick[i], data.other[i], data.time_s(i) - data.start_s);
  }
  const double shift = model.delay_s / data.period_s;
  std::vector<double> late(now.size());
  for (std::size_t i = 0; i < now.size(); ++i) {
    const double at = std::max(0.0, static_cast<double>(i) - shift);
    const auto low = static_cast<std::size_t>(at);
    const double part = at - static_cast<double>(low);
    late[i] = now[low] * (1.0 - part) + now[std::min(low + 1, now.size() - 1)] * part;
  }
  return late;
}

std::size_t pose_age_samples(const logs::FlightLog& log) {
  const auto age = log.extra.find("pose_age");
  double mean_s = 0.0;
  if (age != log.extra.end()) {
    for (const double one : age->second) {
      mean_s += one / static_cast<double>(age->second.size());
    }
  }
  return static_cast<std::size_t>(std::lround(mean_s / log.period_s));
}

std::vector<double> velocity(const logs::FlightLog& log, Signal position) {
  const std::vector<double>& x = log.of(position);
  const std::size_t shift = pose_age_samples(log);
  std::vector<double> out(x.size(), 0.0);
  for (std::size_t i = 5; i + shift + 5 < x.size(); ++i) {
    out[i] = (x[i + shift + 5] - x[i + shift - 5]) / (10.0 * log.period_s);
  }
  return out;
}

}  // namespace

logs::FlightLog with_captured_velocity(const logs::FlightLog& log) {
  logs::FlightLog out = log;
  const std::size_t shift = pose_age_samples(log);
  for (int c = 0; c < 3; ++c) {
    out.of(logs::offset(Signal::kVelocityX, c)) = velocity(log, logs::offset(Signal::kPositionX, c));
    std::vector<double>& x = out.of(logs::offset(Signal::kPositionX, c));
    std::copy(x.begin() + static_cast<std::ptrdiff_t>(shift), x.end(), x.begin());
  }
  return out;
}

Prediction predict(const model::Vehicle& vehicle, const logs::FlightLog& log, double from_s, double to_s) {
  const AxisData roll = axis_data(log, Signal::kStickRoll, Signal::kStickPitch, Signal::kAttitudeRoll);
  const AxisData pitch = axis_data(log, Signal::kStickPitch, Signal::kStickRoll, Signal::kAttitudePitch);
  const AxisData climb = axis_data(log, Signal::kStickThrottle, Signal::kStickYaw, Signal::kVelocityZ);
  const sysid::AxisModel<double> roll_model = sysid::to_axis_model(vehicle.roll);
  const sysid::AxisModel<double> pitch_model = sysid::to_axis_model(vehicle.pitch);
  Prediction out;
  out.roll_rad = errors(roll, from_s, to_s, roll_model);
  out.pitch_rad = errors(pitch, from_s, to_s, pitch_model);
  out.climb_m_s = errors(climb, from_s, to_s, sysid::to_axis_model(vehicle.climb));

  const std::vector<double> roll_command = commands(roll, roll_model);
  const std::vector<double> pitch_command = commands(pitch, pitch_model);
  const sysid::AxisModel<double> climb_model = sysid::to_axis_model(vehicle.climb);
  const std::vector<double> climb_command = commands(climb, climb_model);
  const std::vector<double> velocity_x = velocity(log, Signal::kPositionX);
  const std::vector<double> velocity_y = velocity(log, Signal::kPositionY);
  const std::vector<double>& yaw = log.of(Signal::kAttitudeYaw);
  const std::size_t last = log.index_of(to_s);
  std::array<double, kHorizons_s.size()> sum{};
  std::array<double, kHorizons_s.size()> mean_x{};
  std::array<double, kHorizons_s.size()> mean_y{};
  std::array<double, kHorizons_s.size()> count{};
  const auto slope = [](const std::vector<double>& x, std::size_t i) { return (x[i + 3] - x[i - 3]) / 0.06; };
  for (std::size_t begin = log.index_of(from_s) + 5; begin + 220 < last; begin += 10) {
    sysid::AxisDynamics<double> roll_now(roll_model, log.period_s);
    sysid::AxisDynamics<double> pitch_now(pitch_model, log.period_s);
    roll_now.start(roll.measured[begin], slope(roll.measured, begin));
    pitch_now.start(pitch.measured[begin], slope(pitch.measured, begin));
    sysid::AxisDynamics<double> climb_now(climb_model, log.period_s);
    climb_now.start(climb.measured[begin], slope(climb.measured, begin));
    double vx = velocity_x[begin];
    double vy = velocity_y[begin];
    std::size_t horizon = 0;
    for (std::size_t k = 1; horizon < kHorizons_s.size(); ++k) {
      const std::size_t i = begin + k;
      const double climb_before = climb_now.value();
      const double lift_m_s2 = vehicle.translation.tilt_gain * model::kGravity_m_s2 +
                               (climb_now.step(climb_command[i - 1]) - climb_before) / log.period_s;
      const double pitch_rad = pitch_now.step(pitch_command[i - 1]);
      const double forward = lift_m_s2 * std::tan(pitch_rad);
      const double left = -lift_m_s2 * std::tan(roll_now.step(roll_command[i - 1])) / std::cos(pitch_rad);
      const double drag =
          vehicle.translation.linear_drag_per_s + vehicle.translation.quadratic_drag_per_m * std::hypot(vx, vy);
      vx += log.period_s * (std::cos(yaw[i]) * forward - std::sin(yaw[i]) * left - drag * vx);
      vy += log.period_s * (std::sin(yaw[i]) * forward + std::cos(yaw[i]) * left - drag * vy);
      if (static_cast<double>(k) * log.period_s >= kHorizons_s[horizon] - 1e-9) {
        const double ex = vx - velocity_x[i];
        const double ey = vy - velocity_y[i];
        sum[horizon] += ex * ex + ey * ey;
        mean_x[horizon] += ex;
        mean_y[horizon] += ey;
        count[horizon] += 1.0;
        ++horizon;
      }
    }
  }
  for (std::size_t i = 0; i < sum.size(); ++i) {
    // The mean error is the steady wind, which the observer learns in flight.
    const double n = std::max(1.0, count[i]);
    const double steady = (mean_x[i] * mean_x[i] + mean_y[i] * mean_y[i]) / (n * n);
    out.velocity_m_s[i] = std::sqrt(std::max(0.0, sum[i] / n - steady));
  }
  return out;
}

}  // namespace m100::tools::loop
