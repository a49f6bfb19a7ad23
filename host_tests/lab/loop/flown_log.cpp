// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/loop/flown_log.h"

#include <algorithm>
#include <fstream>
#include <sstream>

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/loop/prediction.h"
#include "host_tests/sim/world/random.h"

namespace m100::lab::loop {
namespace {

/// The values of so many samples ago (negative: of later ones), between samples by straight lines; the ends are held.
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

}  // namespace

const std::string& own_columns() {
  static const std::string text = R"(time = { column = "tick.timestamp", scale = 1.0 }
[signals]
stick_roll = { column = "tick.sticks[0]", offset = -1024 }
stick_pitch = { column = "tick.sticks[1]", offset = -1024 }
stick_throttle = { column = "tick.sticks[2]", offset = -1024 }
stick_yaw = { column = "tick.sticks[3]", offset = -1024 }
attitude_roll = "tick.imu_attitude[0]"
attitude_pitch = "tick.imu_attitude[1]"
attitude_yaw = "tick.imu_attitude[2]"
rate_x = "tick.imu_rate[0]"
rate_y = "tick.imu_rate[1]"
rate_z = "tick.imu_rate[2]"
position_x = "tick.pose_position[0]"
position_y = "tick.pose_position[1]"
position_z = "tick.pose_position[2]"
velocity_x = "tick.velocity[0]"
velocity_y = "tick.velocity[1]"
velocity_z = "tick.velocity[2]"
[extra]
pose_age = "tick.pose_age"
)";
  return text;
}

std::string excitation(std::uint64_t seed, double duration_s) {
  sim::Random random(seed, "excitation");
  const auto between = [&random](double low, double high) { return low + (high - low) * random.uniform(); };
  std::ostringstream course;
  course << "step 0 0 0 0 4\n";
  double t_s = 4.0;
  for (int leg = 0; t_s < duration_s && leg < 60; ++leg) {
    const double size = leg % 3 == 0 ? 0.3 : (leg % 3 == 1 ? 1.0 : 2.0);
    const double x = between(-size, size), y = between(-size, size), z = between(-0.8, 0.8);
    const double yaw = between(-1.0, 1.0), stay_s = between(0.8, 2.4);
    course << "step " << x << " " << y << " " << z << " " << yaw << " " << stay_s << "\n";
    t_s += stay_s;
  }
  return course.str();
}

logs::FlightLog load_flown(const experiments::FlightResult& flight, const std::string& path) {
  {
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(flight.log.data()), static_cast<std::streamsize>(flight.log.size()));
    if (!file) {
      throw InputError(path, 0, "", "cannot be written");
    }
  }
  logs::FlightLog log = logs::load(*logs::open_ulog(path), logs::parse_column_map(own_columns(), "(own columns)"));
  using logs::Signal;
  for (const Signal stick : {Signal::kStickRoll, Signal::kStickPitch, Signal::kStickThrottle, Signal::kStickYaw}) {
    const double way_s = stick == Signal::kStickThrottle ? kClimbUplink_s : kUplink_s;
    log.of(stick) = moved_later(log.of(stick), way_s / log.period_s);
  }
  for (const Signal felt : {Signal::kAttitudeRoll, Signal::kAttitudePitch, Signal::kAttitudeYaw, Signal::kRateX,
                            Signal::kRateY, Signal::kRateZ}) {
    log.of(felt) = moved_later(log.of(felt), -kTelemetry_s / log.period_s);
  }
  return with_captured_velocity(log);
}

}  // namespace m100::lab::loop
