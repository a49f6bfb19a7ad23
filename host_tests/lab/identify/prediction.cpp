// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/prediction.h"

#include <algorithm>
#include <cmath>

#include "firmware/sysid/axis_dynamics.h"
#include "host_tests/lab/identify/data/axis_signals.h"
#include "host_tests/lab/identify/model/axis/axis_blocks.h"
#include "host_tests/lab/identify/model/axis/free_run.h"
#include "host_tests/lab/identify/model/whitening.h"

namespace m100::lab::identify {
namespace {

using logs::Signal;

/// The axis' commands over the whole log as they act, after transport delay and lead zero.
std::vector<double> commands(const AxisData& data, const model::StickAxis& model) {
  model::StickLaw<double> law(model, data.period_s);
  std::vector<double> now(data.stick.size());
  for (std::size_t i = 0; i < now.size(); ++i) {
    now[i] = law.command(data.stick[i], data.other.empty() ? 0.0 : data.other[i], data.time_s(i) - data.start_s);
  }
  std::vector<double> late(now.size());
  arrived_commands(now, model, data.period_s, 0, late);
  return late;
}

/// The velocity along an axis of the world (0: x); the derivative of the position if it was not logged.
std::vector<double> velocity(const logs::FlightLog& log, int axis) {
  const std::vector<double>& logged = log.of(logs::offset(Signal::kVelocityX, axis));
  return logged.empty() ? derivative(log.of(logs::offset(Signal::kPositionX, axis)), log.period_s) : logged;
}

/// A stick axis: its stick and measured response in a log, and its model in a vehicle.
struct LoggedAxis {
  LoggedAxis(const model::Vehicle& vehicle, const logs::FlightLog& log, const std::string& channel) {
    const auto read = [&](Signal stick, Signal other, const model::StickAxis& axis, std::vector<double> measured) {
      data.start_s = log.start_s;
      data.period_s = log.period_s;
      data.stick = log.of(stick);
      data.other = log.of(other);
      data.measured = std::move(measured);
      data.valid.assign(data.measured.size(), 1);
      model = axis;
    };
    if (channel == "roll") {
      read(Signal::kStickRoll, Signal::kStickPitch, vehicle.roll, log.of(Signal::kAttitudeRoll));
    } else if (channel == "pitch") {
      read(Signal::kStickPitch, Signal::kStickRoll, vehicle.pitch, log.of(Signal::kAttitudePitch));
    } else if (channel == "climb") {
      read(Signal::kStickThrottle, Signal::kStickYaw, vehicle.climb, velocity(log, 2));
    } else {
      read(Signal::kStickYaw, Signal::kStickThrottle, vehicle.yaw_rate, log.of(Signal::kRateZ));
      model.scale_per_count = -model.scale_per_count;  // its stick is positive to the right, the rate to the left
    }
  }

  AxisData data;
  model::StickAxis model;
};

/// One stick axis with its commands by the vehicle file; from() starts a forecast at a sample.
struct AxisForecast : LoggedAxis {
  AxisForecast(const model::Vehicle& vehicle, const logs::FlightLog& log, const std::string& channel)
      : LoggedAxis(vehicle, log, channel), command(commands(data, model)) {}

  sysid::AxisDynamics<double> from(std::size_t begin) const {
    sysid::AxisDynamics<double> out(model, data.period_s);
    const std::vector<double>& x = data.measured;
    out.start(x[begin], (x[begin + 3] - x[begin - 3]) / (6.0 * data.period_s));
    return out;
  }

  std::vector<double> command;
};

using Horizontal = std::array<double, 2>;

/// What a horizontal motion is predicted from.
struct MotionForecasts {
  MotionForecasts(const model::Vehicle& vehicle, const logs::FlightLog& log)
      : translation(vehicle.translation),
        yaw(log.of(Signal::kAttitudeYaw)),
        roll(vehicle, log, "roll"),
        pitch(vehicle, log, "pitch"),
        climb(vehicle, log, "climb") {}

  const model::Translation& translation;
  const std::vector<double>& yaw;
  AxisForecast roll, pitch, climb;
};

/// Forecasts the horizontal velocity, and the way flown, from a start time, with the logged sticks after it.
class MotionForecast {
 public:
  MotionForecast(const MotionForecasts& of, std::size_t begin, const Horizontal& velocity_m_s)
      : of_(of),
        roll_(of.roll.from(begin)),
        pitch_(of.pitch.from(begin)),
        climb_(of.climb.from(begin)),
        velocity_m_s_(velocity_m_s) {}

  /// Advances to sample i. Precondition: called for consecutive samples.
  void step(std::size_t i) {
    const double period_s = of_.climb.data.period_s;
    const double climb_before = climb_.value();
    const double lift_m_s2 = of_.translation.tilt_gain * model::kGravity_m_s2 +
                             (climb_.step(of_.climb.command[i - 1]) - climb_before) / period_s;
    const double pitch_rad = pitch_.step(of_.pitch.command[i - 1]);
    const double forward = lift_m_s2 * std::tan(pitch_rad);
    const double left = -lift_m_s2 * std::tan(roll_.step(of_.roll.command[i - 1])) / std::cos(pitch_rad);
    const double cosine = std::cos(of_.yaw[i]), sine = std::sin(of_.yaw[i]);
    const model::Acceleration air =
        model::outer_acceleration(of_.translation,
                                  {.air_velocity_w_m_s = {velocity_m_s_[0], velocity_m_s_[1], 0.0},
                                   .heading_cosine = cosine,
                                   .heading_sine = sine},
                                  1.0);
    const Horizontal before = velocity_m_s_;
    velocity_m_s_[0] += period_s * (cosine * forward - sine * left + air[0]);
    velocity_m_s_[1] += period_s * (sine * forward + cosine * left + air[1]);
    for (std::size_t axis : {0U, 1U}) {
      way_m_[axis] += 0.5 * period_s * (before[axis] + velocity_m_s_[axis]);
    }
  }
  const Horizontal& velocity_m_s() const { return velocity_m_s_; }
  const Horizontal& way_m() const { return way_m_; }

 private:
  const MotionForecasts& of_;
  sysid::AxisDynamics<double> roll_, pitch_, climb_;
  Horizontal velocity_m_s_;
  Horizontal way_m_{};
};

/// Sums over the horizontal errors at one horizon.
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

HorizonErrors ahead(const model::Vehicle& vehicle, const UnseenFlight& flight, const std::string& channel) {
  if (channel == "translation") {
    return predict_motion(vehicle, flight).velocity_m_s;
  }
  const LoggedAxis one(vehicle, *flight.log, channel);
  return horizon_rmse(one.data, flight.ranges, one.model);
}

}  // namespace

Prediction predict_motion(const model::Vehicle& vehicle, const UnseenFlight& flight) {
  const logs::FlightLog& log = *flight.log;
  const MotionForecasts forecasts(vehicle, log);
  const std::vector<double> vx = velocity(log, 0), vy = velocity(log, 1);
  const std::vector<double>&px = log.of(Signal::kPositionX), &py = log.of(Signal::kPositionY);
  std::array<ErrorSums, kHorizons_s.size()> of_velocity, of_position;
  for (const Range& range : flight.ranges) {
    const std::size_t last = log.index_of(range.second);
    for (std::size_t begin = log.index_of(range.first) + 5; begin + 220 < last; begin += 10) {
      MotionForecast forecast(forecasts, begin, {vx[begin], vy[begin]});
      for (std::size_t horizon = 0, i = begin + 1; horizon < kHorizons_s.size(); ++i) {
        forecast.step(i);
        if (static_cast<double>(i - begin) * log.period_s < kHorizons_s[horizon] - 1e-9) {
          continue;
        }
        const auto& [to_x, to_y] = forecast.velocity_m_s();
        of_velocity[horizon].add(to_x - vx[i], to_y - vy[i]);
        if (!px.empty() && !py.empty()) {
          of_position[horizon].add(px[begin] + forecast.way_m()[0] - px[i], py[begin] + forecast.way_m()[1] - py[i]);
        }
        ++horizon;
      }
    }
  }
  Prediction out;
  std::transform(of_velocity.begin(), of_velocity.end(), out.velocity_m_s.begin(), std::mem_fn(&ErrorSums::rms));
  std::transform(of_position.begin(), of_position.end(), out.position_m.begin(), std::mem_fn(&ErrorSums::rms));
  return out;
}

Prediction predict(const model::Vehicle& vehicle, const UnseenFlight& flight) {
  Prediction out = predict_motion(vehicle, flight);
  out.roll_rad = ahead(vehicle, flight, "roll");
  out.pitch_rad = ahead(vehicle, flight, "pitch");
  out.climb_m_s = ahead(vehicle, flight, "climb");
  out.yaw_rate_rad_s = ahead(vehicle, flight, "yaw_rate");
  return out;
}

double error_at_1s(const model::Vehicle& vehicle, const UnseenFlight& flight, const std::string& channel) {
  return ahead(vehicle, flight, channel)[kOneSecond];
}

double innovations(const model::Vehicle& vehicle, const UnseenFlight& flight, const std::string& channel) {
  const LoggedAxis one(vehicle, *flight.log, channel);
  const FreeRun run(one.data, flight.ranges);
  return run.score(run.error(one.model));
}

}  // namespace m100::lab::identify
