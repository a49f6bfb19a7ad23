// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/flight/recording_series.h"

#include <algorithm>

#include "host_tests/lab/input_error.h"

namespace m100::lab::flight {
namespace {

/// A column with the times of its own stream; empty if the recording lacks it.
Timed column(const logs::RawLog& raw, const std::string& name) {
  try {
    logs::RawColumn read = raw.column(name, "flight");
    return {std::move(read.time_s), std::move(read.values)};
  } catch (const InputError&) {
    return {};
  }
}

void shift(std::vector<double>& t_s, double by_s) {
  std::for_each(t_s.begin(), t_s.end(), [by_s](double& t) { t -= by_s; });
}

}  // namespace

FlightSeries recording_series(const logs::RawLog& raw, const std::string& name) {
  FlightSeries out;
  out.name = name;
  out.is_recording = true;
  constexpr std::array kSticks{"rc.roll", "rc.pitch", "rc.throttle", "rc.yaw"};
  constexpr std::array kAngles{"attitude.roll", "attitude.pitch", "attitude.yaw"};
  for (std::size_t i = 0; i < kSticks.size(); ++i) {
    out.sticks_counts[i] = column(raw, kSticks[i]);
  }
  for (std::size_t i = 0; i < kAngles.size(); ++i) {
    Timed angle = column(raw, kAngles[i]);
    out.attitude_t_s = std::move(angle.t_s);
    out.attitude_rad[i] = std::move(angle.values);
  }
  out.battery_percent = column(raw, "status.battery_percent");
  Timed arrived = column(raw, "pose.arrived");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Timed pose = column(raw, "pose.xyz[" + std::to_string(axis) + "]");
    out.poses.resize(std::max(out.poses.size(), pose.t_s.size()));
    for (std::size_t i = 0; i < pose.t_s.size(); ++i) {
      out.poses[i].captured_s = pose.t_s[i];
      out.poses[i].t_s = i < arrived.values.size() ? 1e-6 * arrived.values[i] : pose.t_s[i];
      out.poses[i].position_m[axis] = pose.values[i];
    }
  }
  double first = out.attitude_t_s.empty() ? 1e18 : out.attitude_t_s.front();
  for (const Timed& stick : out.sticks_counts) {
    first = stick.t_s.empty() ? first : std::min(first, stick.t_s.front());
  }
  first = out.poses.empty() ? first : std::min(first, out.poses.front().captured_s);
  for (Timed& stick : out.sticks_counts) {
    shift(stick.t_s, first);
  }
  shift(out.attitude_t_s, first);
  shift(out.battery_percent.t_s, first);
  for (Pose& pose : out.poses) {
    pose.t_s -= first;
    pose.captured_s -= first;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      out.position_m[axis].push_back(pose.position_m[axis]);
    }
    out.t_s.push_back(pose.captured_s);
  }
  out.end_s = !out.attitude_t_s.empty() ? out.attitude_t_s.back() : out.t_s.empty() ? 0.0 : out.t_s.back();
  out.notes.emplace_back("A recording of a flight by hand has no course: it shows no error.");
  return out;
}

}  // namespace m100::lab::flight
