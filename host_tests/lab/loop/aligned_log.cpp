// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/loop/aligned_log.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "firmware/safety/failsafe.h"
#include "host_tests/lab/logs/alignment/capture_alignment.h"
#include "host_tests/lab/logs/formats/ulog.h"
#include "host_tests/lab/statistics.h"
#include "host_tests/lab/whole_file.h"
#include "host_tests/sim/world/random.h"

namespace m100::lab::loop {
namespace {

using identify::Range;

/// Signals that only the loop needs from its own log; they are not used for identification.
constexpr const char* kHeadingAndState = "pose_yaw = \"tick.pose_yaw\"\nstate = \"tick.state\"\n";

/// The longest time in which the failsafe states are nominal, coast or level: the aircraft is under our control.
Range in_control(const logs::FlightLog& log, const std::vector<double>& failsafe_state) {
  const auto kept = [](double value) {
    return value > static_cast<double>(safety::FailsafeState::kNominal) - 0.5 &&
           value < static_cast<double>(safety::FailsafeState::kLevel) + 0.5;
  };
  Range best{log.start_s, log.start_s};
  for (std::size_t begin = 0; begin < failsafe_state.size();) {
    std::size_t end = begin;
    while (end < failsafe_state.size() && kept(failsafe_state[end])) {
      ++end;
    }
    if (log.time_s(end) - log.time_s(begin) > best.second - best.first) {
      best = {log.time_s(begin), log.time_s(end)};
    }
    begin = std::max(end, begin + 1);
  }
  return best;
}

/// Removes an extra column from the log and returns it, so that identification does not test it as a cause.
std::vector<double> taken(logs::FlightLog& log, const char* name) {
  const auto found = log.extra.find(name);
  if (found == log.extra.end()) {
    return {};
  }
  std::vector<double> out = std::move(found->second);
  log.extra.erase(found);
  return out;
}

void turn_rates_into_heading(logs::FlightLog& log) {
  using logs::Signal;
  std::vector<double>& rate = log.of(Signal::kRateZ);
  for (std::size_t i = 0; i < rate.size(); ++i) {
    const double roll = log.of(Signal::kAttitudeRoll)[i];
    rate[i] = (std::sin(roll) * log.of(Signal::kRateY)[i] + std::cos(roll) * rate[i]) /
              std::cos(log.of(Signal::kAttitudePitch)[i]);
  }
}

}  // namespace

const std::string& own_columns() {
  static const std::string text = std::string(kMotionColumns) + R"(position_x = "tick.pose_position[0]"
position_y = "tick.pose_position[1]"
position_z = "tick.pose_position[2]"
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

FlownLog load_flown(const experiments::FlightResult& flight, const std::string& path) {
  write_whole_file(path, {reinterpret_cast<const char*>(flight.log.data()), flight.log.size()});
  FlownLog out;
  out.descent = flight.descent;
  out.log =
      logs::load(*logs::open_ulog(path), logs::parse_column_map(own_columns() + kHeadingAndState, "(own columns)"));
  logs::FlightLog& log = out.log;
  out.in_control = in_control(log, taken(log, "state"));
  using logs::Signal;
  for (const Signal stick : {Signal::kStickRoll, Signal::kStickPitch, Signal::kStickThrottle, Signal::kStickYaw}) {
    log.of(stick) = logs::moved_later(log.of(stick), kUplink_s / log.period_s);
  }
  for (const Signal signal : {Signal::kAttitudeRoll, Signal::kAttitudePitch, Signal::kAttitudeYaw, Signal::kRateX,
                              Signal::kRateY, Signal::kRateZ}) {
    log.of(signal) = logs::moved_later(log.of(signal), -kTelemetry_s / log.period_s);
  }
  turn_rates_into_heading(log);
  const double believed_age_s = mean_value(taken(log, "pose_age"));
  const double lag_s = logs::capture_lag_s(log, taken(log, "pose_yaw"), out.in_control, believed_age_s);
  log = logs::with_captured_velocity(std::move(log), lag_s);
  return out;
}

}  // namespace m100::lab::loop
