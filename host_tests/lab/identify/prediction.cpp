// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/prediction.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "firmware/sysid/axis_dynamics.h"
#include "host_tests/lab/identify/data/axis_signals.h"
#include "host_tests/lab/identify/model/axis/axis_blocks.h"
#include "host_tests/lab/identify/model/axis/free_run.h"
#include "host_tests/lab/identify/model/whitening.h"

namespace m100::lab::identify {
namespace {

using logs::Signal;

AxisData axis_data(const logs::FlightLog& log, Signal stick, Signal other, Signal measured) {
  AxisData data;
  data.start_s = log.start_s;
  data.period_s = log.period_s;
  data.stick = log.of(stick);
  data.other = log.of(other);
  const bool from_height = measured == Signal::kVelocityZ && !log.has(Signal::kVelocityZ);
  data.measured = from_height ? derivative(log.of(Signal::kPositionZ), log.period_s) : log.of(measured);
  data.valid.assign(data.measured.size(), 1);
  return data;
}

/// The axis' commands over the whole log as they act, after transport delay and lead zero.
std::vector<double> commands(const AxisData& data, const model::StickAxis& model) {
  model::StickLaw<double> law(model, data.period_s);
  std::vector<double> now(data.stick.size());
  for (std::size_t i = 0; i < now.size(); ++i) {
    now[i] = law.command(data.stick[i], data.other[i], data.time_s(i) - data.start_s);
  }
  std::vector<double> late(now.size());
  arrived_commands(now, model, data.period_s, 0, late);
  return late;
}

/// One stick axis: its measured response and its commands by the vehicle file; from() starts a forecast at a sample.
struct AxisForecast {
  AxisForecast(const logs::FlightLog& log, Signal stick, Signal other, Signal measured, const model::StickAxis& axis)
      : data(axis_data(log, stick, other, measured)), command(commands(data, axis)), model(axis) {}

  sysid::AxisDynamics<double> from(std::size_t begin) const {
    sysid::AxisDynamics<double> out(model, data.period_s);
    const std::vector<double>& x = data.measured;
    out.start(x[begin], (x[begin + 3] - x[begin - 3]) / (6.0 * data.period_s));
    return out;
  }

  AxisData data;
  std::vector<double> command;
  const model::StickAxis& model;
};

using Velocity = std::array<double, 2>;

/// Forecasts the horizontal velocity from a start time, with the logged sticks after it.
class VelocityForecast {
 public:
  VelocityForecast(const model::Translation& translation, const std::vector<double>& yaw, const AxisForecast& roll,
                   const AxisForecast& pitch, const AxisForecast& climb, std::size_t begin, const Velocity& velocity)
      : translation_(translation),
        yaw_(yaw),
        roll_(roll),
        pitch_(pitch),
        climb_(climb),
        roll_now_(roll.from(begin)),
        pitch_now_(pitch.from(begin)),
        climb_now_(climb.from(begin)),
        velocity_(velocity) {}

  /// @returns the velocity at sample i. Precondition: called for consecutive samples.
  const Velocity& at(std::size_t i) {
    const double period_s = climb_.data.period_s;
    const double climb_before = climb_now_.value();
    const double lift_m_s2 = translation_.tilt_gain * model::kGravity_m_s2 +
                             (climb_now_.step(climb_.command[i - 1]) - climb_before) / period_s;
    const double pitch_rad = pitch_now_.step(pitch_.command[i - 1]);
    const double forward = lift_m_s2 * std::tan(pitch_rad);
    const double left = -lift_m_s2 * std::tan(roll_now_.step(roll_.command[i - 1])) / std::cos(pitch_rad);
    const double cosine = std::cos(yaw_[i]), sine = std::sin(yaw_[i]);
    const model::Acceleration air = model::outer_acceleration(
        translation_,
        {.air_velocity_w_m_s = {velocity_[0], velocity_[1], 0.0}, .heading_cosine = cosine, .heading_sine = sine}, 1.0);
    velocity_[0] += period_s * (cosine * forward - sine * left + air[0]);
    velocity_[1] += period_s * (sine * forward + cosine * left + air[1]);
    return velocity_;
  }

 private:
  const model::Translation& translation_;
  const std::vector<double>& yaw_;
  const AxisForecast& roll_;
  const AxisForecast& pitch_;
  const AxisForecast& climb_;
  sysid::AxisDynamics<double> roll_now_, pitch_now_, climb_now_;
  Velocity velocity_;
};

/// Sums over the velocity errors at one horizon.
struct ErrorSums {
  double squares = 0.0, x = 0.0, y = 0.0, count = 0.0;

  void add(double ex, double ey) {
    squares += ex * ex + ey * ey;
    x += ex;
    y += ey;
    count += 1.0;
  }
  /// Root mean square without the mean error, which is the steady wind that the observer learns in flight.
  double rms() const {
    const double n = std::max(1.0, count);
    return std::sqrt(std::max(0.0, squares / n - (x * x + y * y) / (n * n)));
  }
};

/// Errors of the forecast velocity at every horizon, with a start every ten samples.
HorizonErrors velocity_errors(const model::Translation& translation, const logs::FlightLog& log,
                              const AxisForecast& roll, const AxisForecast& pitch, const AxisForecast& climb,
                              double from_s, double to_s) {
  const std::vector<double>& velocity_x = log.of(Signal::kVelocityX);
  const std::vector<double>& velocity_y = log.of(Signal::kVelocityY);
  const std::size_t last = log.index_of(to_s);
  std::array<ErrorSums, kHorizons_s.size()> sums;
  for (std::size_t begin = log.index_of(from_s) + 5; begin + 220 < last; begin += 10) {
    VelocityForecast forecast(translation, log.of(Signal::kAttitudeYaw), roll, pitch, climb, begin,
                              {velocity_x[begin], velocity_y[begin]});
    std::size_t horizon = 0;
    for (std::size_t k = 1; horizon < kHorizons_s.size(); ++k) {
      const std::size_t i = begin + k;
      const Velocity& v = forecast.at(i);
      if (static_cast<double>(k) * log.period_s >= kHorizons_s[horizon] - 1e-9) {
        sums[horizon].add(v[0] - velocity_x[i], v[1] - velocity_y[i]);
        ++horizon;
      }
    }
  }
  HorizonErrors out{};
  std::transform(sums.begin(), sums.end(), out.begin(), [](const ErrorSums& one) { return one.rms(); });
  return out;
}

HorizonErrors velocity_ahead(const model::Vehicle& vehicle, const UnseenFlight& flight) {
  const logs::FlightLog& log = *flight.log;
  const AxisForecast roll(log, Signal::kStickRoll, Signal::kStickPitch, Signal::kAttitudeRoll, vehicle.roll);
  const AxisForecast pitch(log, Signal::kStickPitch, Signal::kStickRoll, Signal::kAttitudePitch, vehicle.pitch);
  const AxisForecast climb(log, Signal::kStickThrottle, Signal::kStickYaw, Signal::kVelocityZ, vehicle.climb);
  return velocity_errors(vehicle.translation, log, roll, pitch, climb, flight.from_s, flight.to_s);
}

/// The signals of a stick axis in a log, and its model in the vehicle file.
struct LoggedAxis {
  AxisData data;
  model::StickAxis axis;
};

LoggedAxis logged_axis(const model::Vehicle& vehicle, const logs::FlightLog& log, const std::string& channel) {
  if (channel == "roll") {
    return {axis_data(log, Signal::kStickRoll, Signal::kStickPitch, Signal::kAttitudeRoll), vehicle.roll};
  }
  if (channel == "pitch") {
    return {axis_data(log, Signal::kStickPitch, Signal::kStickRoll, Signal::kAttitudePitch), vehicle.pitch};
  }
  if (channel == "climb") {
    return {axis_data(log, Signal::kStickThrottle, Signal::kStickYaw, Signal::kVelocityZ), vehicle.climb};
  }
  model::StickAxis yaw = vehicle.yaw_rate;  // its stick is positive to the right, the rate to the left
  yaw.scale_per_count = -yaw.scale_per_count;
  return {axis_data(log, Signal::kStickYaw, Signal::kStickThrottle, Signal::kRateZ), yaw};
}

HorizonErrors ahead(const model::Vehicle& vehicle, const UnseenFlight& flight, const std::string& channel) {
  if (channel == "translation") {
    return velocity_ahead(vehicle, flight);
  }
  const LoggedAxis one = logged_axis(vehicle, *flight.log, channel);
  return horizon_rmse(one.data, {{flight.from_s, flight.to_s}}, one.axis);
}

}  // namespace

Prediction predict(const model::Vehicle& vehicle, const logs::FlightLog& log, double from_s, double to_s) {
  const UnseenFlight flight{&log, from_s, to_s};
  Prediction out;
  out.roll_rad = ahead(vehicle, flight, "roll");
  out.pitch_rad = ahead(vehicle, flight, "pitch");
  out.climb_m_s = ahead(vehicle, flight, "climb");
  out.yaw_rate_rad_s = ahead(vehicle, flight, "yaw_rate");
  out.velocity_m_s = ahead(vehicle, flight, "translation");
  return out;
}

double error_at_1s(const model::Vehicle& vehicle, const UnseenFlight& flight, const std::string& channel) {
  return ahead(vehicle, flight, channel)[kOneSecond];
}

double innovations(const model::Vehicle& vehicle, const UnseenFlight& flight, const std::string& channel) {
  const LoggedAxis one = logged_axis(vehicle, *flight.log, channel);
  const FreeRun run(one.data, {{flight.from_s, flight.to_s}});
  return run.score(run.error(one.axis));
}

}  // namespace m100::lab::identify
