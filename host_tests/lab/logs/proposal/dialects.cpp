// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/proposal/dialects.h"

#include <array>
#include <string_view>

#include "host_tests/lab/logs/signal.h"

namespace m100::lab::logs {
namespace {

/// The ends of the columns of a vector, behind their common stem.
using Ends = std::array<const char*, 3>;
constexpr Ends kXyz{".x", ".y", ".z"}, kFromZero{"[0]", "[1]", "[2]"}, kFromOne{"[1]", "[2]", "[3]"};
constexpr Ends kRollPitchYaw{"roll", "pitch", "yaw"};

/// A vector in x, y, z, or an attitude in roll, pitch, yaw.
Group vector(const std::string& quantity, const std::string& stem, const Ends& ends, const std::string& more = "") {
  const std::string unit = quantity == "rates" ? "rate" : quantity;
  const Ends axes = quantity == "attitude" ? kRollPitchYaw : Ends{"x", "y", "z"};
  Group out{quantity, {}};
  for (std::size_t i = 0; i < axes.size(); ++i) {
    out.lines.push_back({unit + "_" + axes[i], stem + ends[i], more});
  }
  return out;
}
/// @param w column of the scalar part, and where the vector's begin.
Group quaternion(const std::string& quantity, const std::string& w, const std::string& stem, const Ends& ends) {
  return {quantity,
          {{quantity + "_qw", w},
           {quantity + "_qx", stem + ends[0]},
           {quantity + "_qy", stem + ends[1]},
           {quantity + "_qz", stem + ends[2]}}};
}
Group sticks(const std::string& stem, const std::array<const char*, 4>& ends, const std::string& more) {
  return {"sticks",
          {{"stick_roll", stem + ends[0], more},
           {"stick_pitch", stem + ends[1], more},
           {"stick_throttle", stem + ends[2], more},
           {"stick_yaw", stem + ends[3], more}}};
}

Dialect own_log() {
  return {"our own flight log",
          "tick.sticks[0]",
          "tick.timestamp",
          "nwu_flu",
          {sticks("tick.sticks", {"[0]", "[1]", "[2]", "[3]"}, "offset = -1024"),
           vector("attitude", "tick.imu_attitude", kFromZero), vector("rates", "tick.imu_rate", kFromZero),
           vector("position", "tick.pose_position", kFromZero), vector("velocity", "tick.velocity", kFromZero)},
          {{"pose_age", "tick.pose_age"}}};
}

/// The log of m100 record; the shipped map host_tests/lab/logs/maps/m100_recording_with_pose.toml is equivalent.
Dialect own_recording() {
  return {"our own recording",
          "rc.roll",
          "attitude.timestamp",
          "nwu_flu",
          {sticks("rc.", {"roll", "pitch", "throttle", "yaw"}, "scale = 0.066"),  // -10000..10000 are 660 counts
           vector("attitude", "attitude.", kRollPitchYaw), vector("rates", "rates.xyz", kFromZero),
           vector("velocity", "velocity.xyz", kFromZero),
           vector("force", "force.xyz", kFromZero, "scale = 9.80665"),  // "raw" in DJI's assistant is in units of g
           vector("position", "pose.xyz", kFromZero)},
          {{"battery", "status.battery_percent"}, {"pose_yaw", "pose.yaw"}}};
}

Dialect px4() {
  const std::string setpoint = "vehicle_attitude_setpoint.", place = "vehicle_local_position.";
  return {"PX4",
          "vehicle_attitude.q[0]",
          "vehicle_attitude.timestamp",
          "ned_frd",
          {quaternion("attitude", "vehicle_attitude.q[0]", "vehicle_attitude.q", kFromOne),
           {"command", {{"command_roll", setpoint + "roll_body"}, {"command_pitch", setpoint + "pitch_body"}}},
           quaternion("command", setpoint + "q_d[0]", setpoint + "q_d", kFromOne),
           {"yaw command", {{"command_yaw_rate", "vehicle_rates_setpoint.yaw"}}},
           {"climb command", {{"command_climb", "vehicle_local_position_setpoint.vz"}}},
           vector("rates", "vehicle_angular_velocity.xyz", kFromZero),
           vector("rates", "vehicle_attitude.", {"rollspeed", "pitchspeed", "yawspeed"}),
           vector("rates", "sensor_combined.gyro_rad", kFromZero),
           vector("force", "sensor_combined.accelerometer_m_s2", kFromZero),
           vector("velocity", place, {"vx", "vy", "vz"}),
           vector("position", place, {"x", "y", "z"})},
          {{"battery", "battery_status.voltage_v"}}};
}

/// @param time  ATT.TimeUS, or ATT.TimeMS in logs up to 2015.
Dialect ardupilot(const std::string& time) {
  const std::string degrees = "scale = 0.017453292519943295";
  const Ends velocity{"VN", "VE", "VD"}, position{"PN", "PE", "PD"};
  return {"ArduPilot",
          "ATT.Roll",
          time,
          "ned_frd",
          {vector("attitude", "ATT.", {"Roll", "Pitch", "Yaw"}, degrees),
           {"command", {{"command_roll", "ATT.DesRoll", degrees}, {"command_pitch", "ATT.DesPitch", degrees}}},
           {"yaw command", {{"command_yaw_rate", "RATE.YDes", degrees}}},
           {"climb command", {{"command_climb", "PSCD.TVD"}}},
           vector("rates", "RATE.", {"R", "P", "Y"}, degrees),
           vector("rates", "IMU.", {"GyrX", "GyrY", "GyrZ"}),
           vector("force", "IMU.", {"AccX", "AccY", "AccZ"}),
           vector("velocity", "XKF1.", velocity),
           vector("velocity", "NKF1.", velocity),
           vector("position", "XKF1.", position),
           vector("position", "NKF1.", position)},
          {{"battery", "BAT.Volt"}}};
}

/// A bag is known by the quaternion of its attitude; the other groups are the same for all bags.
Dialect bag(const std::string& name, const std::string& topic, const std::string& field) {
  const std::string stem = topic + field;
  return {
      name,
      stem + ".w",
      topic + ".time",
      "nwu_flu",
      {quaternion("attitude", stem + ".w", stem, kXyz),
       sticks("/dji_sdk/rc.axes", {"[0]", "[1]", "[3]", "[2]"}, "scale = 660"),
       sticks("<Joy>.axes", {"[0]", "[1]", "[3]", "[2]"}, "scale = 660"),
       vector("rates", "<Imu>.angular_velocity", kXyz), vector("force", "<Imu>.linear_acceleration", kXyz),
       vector("velocity", "/dji_sdk/velocity.vector", kXyz), vector("velocity", "<TwistStamped>.twist.linear", kXyz),
       vector("position", "<PoseStamped>.pose.position", kXyz),
       vector("position", "<TransformStamped>.transform.translation", kXyz),
       vector("position", "<Odometry>.pose.pose.position", kXyz),
       vector("position", "/dji_sdk/local_position.point", kXyz)},
      {}};
}

Dialect published_mat() {
  const std::string experiment = "Experiment1.";
  return {"the published MAT-files",
          experiment + "RCData.channel[1]",
          experiment + "Vicon.t",
          "nwu_flu",
          {sticks(experiment + "RCData.channel", {"[2]", "[1]", "[3]", "[4]"}, "offset = -1024"),
           vector("attitude", experiment + "rpy", kFromOne),
           vector("rates", experiment + "Vicon.w", kFromOne),
           {"velocity", {{"velocity_z", experiment + "Vicon.v[3]"}}}},
          {}};
}

Dialect measured_csv() {
  const Ends angles{"roll_rad", "pitch_rad", "yaw_rad"}, rates{"wx_rad_s", "wy_rad_s", "wz_rad_s"};
  return {"the measured flights as CSV",
          "rc_roll",
          "t_s",
          "nwu_flu",
          {{"sequence", {{"sequence", "seq"}}},
           sticks("rc_", {"roll", "pitch", "throttle", "yaw"}, "offset = -1024"),
           vector("attitude", "odom_", angles),
           vector("attitude", "mocap_", angles),
           vector("rates", "odom_", rates),
           vector("rates", "imu_", rates),
           vector("position", "mocap_", {"px_m", "py_m", "pz_m"}),
           vector("velocity", "mocap_", {"vx_m_s", "vy_m_s", "vz_m_s"}),
           {"velocity", {{"velocity_z", "odom_vz_m_s"}}},
           vector("force", "imu_", {"fx_m_s2", "fy_m_s2", "fz_m_s2"})},
          {}};
}

/// The CSV that `convert` writes, with canonical names.
Dialect canonical_csv(const std::string& known_by) {
  Dialect out{"canonical names", known_by, "t_s", "nwu_flu", {}, {}};
  for (const std::string_view name : kSignalNames) {
    out.groups.push_back({std::string(name), {{std::string(name), std::string(name)}}});
  }
  return out;
}

}  // namespace

std::vector<Dialect> dialects() {
  return {own_log(),
          own_recording(),
          px4(),
          ardupilot("ATT.TimeUS"),
          ardupilot("ATT.TimeMS"),
          published_mat(),
          measured_csv(),
          canonical_csv("attitude_roll"),
          canonical_csv("velocity_x"),
          bag("a DJI bag", "/dji_sdk/attitude", ".quaternion"),
          bag("a ROS bag", "<QuaternionStamped>", ".quaternion"),
          bag("a ROS bag", "<PoseStamped>", ".pose.orientation"),
          bag("a ROS bag", "<Odometry>", ".pose.pose.orientation"),
          bag("a ROS bag", "<Imu>", ".orientation")};
}

}  // namespace m100::lab::logs
