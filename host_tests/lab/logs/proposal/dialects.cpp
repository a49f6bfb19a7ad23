// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/proposal/dialects.h"

#include <string_view>

#include "host_tests/lab/logs/signal.h"

namespace m100::lab::logs {
namespace {

std::vector<MapEntry> three(const char* x_signal, const char* x, const char* y_signal, const char* y,
                            const char* z_signal, const char* z, const char* more = "") {
  return {{x_signal, x, more}, {y_signal, y, more}, {z_signal, z, more}};
}
std::vector<MapEntry> attitude_q(const char* w, const char* x, const char* y, const char* z) {
  return {{"attitude_qw", w}, {"attitude_qx", x}, {"attitude_qy", y}, {"attitude_qz", z}};
}
std::vector<MapEntry> rates(const char* x, const char* y, const char* z, const char* more = "") {
  return three("rate_x", x, "rate_y", y, "rate_z", z, more);
}
std::vector<MapEntry> forces(const char* x, const char* y, const char* z) {
  return three("force_x", x, "force_y", y, "force_z", z);
}
std::vector<MapEntry> velocities(const char* x, const char* y, const char* z) {
  return three("velocity_x", x, "velocity_y", y, "velocity_z", z);
}
std::vector<MapEntry> positions(const char* x, const char* y, const char* z) {
  return three("position_x", x, "position_y", y, "position_z", z);
}
std::vector<MapEntry> sticks(const char* roll, const char* pitch, const char* throttle, const char* yaw,
                             const char* more) {
  return {{"stick_roll", roll, more},
          {"stick_pitch", pitch, more},
          {"stick_throttle", throttle, more},
          {"stick_yaw", yaw, more}};
}

Dialect own_log() {
  return {"our own flight log",
          "tick.sticks[0]",
          "tick.timestamp",
          "nwu_flu",
          {{"sticks", sticks("tick.sticks[0]", "tick.sticks[1]", "tick.sticks[2]", "tick.sticks[3]", "offset = -1024")},
           {"attitude", three("attitude_roll", "tick.imu_attitude[0]", "attitude_pitch", "tick.imu_attitude[1]",
                              "attitude_yaw", "tick.imu_attitude[2]")},
           {"rates", rates("tick.imu_rate[0]", "tick.imu_rate[1]", "tick.imu_rate[2]")},
           {"position", positions("tick.pose_position[0]", "tick.pose_position[1]", "tick.pose_position[2]")},
           {"velocity", velocities("tick.velocity[0]", "tick.velocity[1]", "tick.velocity[2]")}},
          {{"pose_age", "tick.pose_age"}}};
}

/// The log of m100 record; the shipped map host_tests/lab/logs/maps/m100_recording_with_pose.toml is equivalent.
Dialect own_recording() {
  const char* const counts = "scale = 0.066";  // -10000..10000 are 660 counts to either side
  return {"our own recording",
          "rc.roll",
          "attitude.timestamp",
          "nwu_flu",
          {{"sticks", sticks("rc.roll", "rc.pitch", "rc.throttle", "rc.yaw", counts)},
           {"attitude", three("attitude_roll", "attitude.roll", "attitude_pitch", "attitude.pitch", "attitude_yaw",
                              "attitude.yaw")},
           {"rates", rates("rates.xyz[0]", "rates.xyz[1]", "rates.xyz[2]")},
           {"velocity", velocities("velocity.xyz[0]", "velocity.xyz[1]", "velocity.xyz[2]")},
           {"force", three("force_x", "force.xyz[0]", "force_y", "force.xyz[1]", "force_z", "force.xyz[2]",
                           "scale = 9.80665")},  // "raw" in DJI's assistant is in units of g
           {"position", positions("pose.xyz[0]", "pose.xyz[1]", "pose.xyz[2]")}},
          {{"battery", "status.battery_percent"}, {"pose_yaw", "pose.yaw"}}};
}

Dialect px4() {
  return {
      "PX4",
      "vehicle_attitude.q[0]",
      "vehicle_attitude.timestamp",
      "ned_frd",
      {{"attitude",
        attitude_q("vehicle_attitude.q[0]", "vehicle_attitude.q[1]", "vehicle_attitude.q[2]", "vehicle_attitude.q[3]")},
       {"command",
        {{"command_roll", "vehicle_attitude_setpoint.roll_body"},
         {"command_pitch", "vehicle_attitude_setpoint.pitch_body"}}},
       {"command",
        {{"command_qw", "vehicle_attitude_setpoint.q_d[0]"},
         {"command_qx", "vehicle_attitude_setpoint.q_d[1]"},
         {"command_qy", "vehicle_attitude_setpoint.q_d[2]"},
         {"command_qz", "vehicle_attitude_setpoint.q_d[3]"}}},
       {"yaw command", {{"command_yaw_rate", "vehicle_rates_setpoint.yaw"}}},
       {"climb command", {{"command_climb", "vehicle_local_position_setpoint.vz"}}},
       {"rates",
        rates("vehicle_angular_velocity.xyz[0]", "vehicle_angular_velocity.xyz[1]", "vehicle_angular_velocity.xyz[2]")},
       {"rates", rates("vehicle_attitude.rollspeed", "vehicle_attitude.pitchspeed", "vehicle_attitude.yawspeed")},
       {"rates", rates("sensor_combined.gyro_rad[0]", "sensor_combined.gyro_rad[1]", "sensor_combined.gyro_rad[2]")},
       {"force", forces("sensor_combined.accelerometer_m_s2[0]", "sensor_combined.accelerometer_m_s2[1]",
                        "sensor_combined.accelerometer_m_s2[2]")},
       {"velocity", velocities("vehicle_local_position.vx", "vehicle_local_position.vy", "vehicle_local_position.vz")},
       {"position", positions("vehicle_local_position.x", "vehicle_local_position.y", "vehicle_local_position.z")}},
      {{"battery", "battery_status.voltage_v"}}};
}

/// @param time  ATT.TimeUS, or ATT.TimeMS in logs up to 2015.
Dialect ardupilot(const char* time) {
  const char* const degrees = "scale = 0.017453292519943295";
  return {"ArduPilot",
          "ATT.Roll",
          time,
          "ned_frd",
          {{"attitude",
            three("attitude_roll", "ATT.Roll", "attitude_pitch", "ATT.Pitch", "attitude_yaw", "ATT.Yaw", degrees)},
           {"command", {{"command_roll", "ATT.DesRoll", degrees}, {"command_pitch", "ATT.DesPitch", degrees}}},
           {"yaw command", {{"command_yaw_rate", "RATE.YDes", degrees}}},
           {"climb command", {{"command_climb", "PSCD.TVD"}}},
           {"rates", rates("RATE.R", "RATE.P", "RATE.Y", degrees)},
           {"rates", rates("IMU.GyrX", "IMU.GyrY", "IMU.GyrZ")},
           {"force", forces("IMU.AccX", "IMU.AccY", "IMU.AccZ")},
           {"velocity", velocities("XKF1.VN", "XKF1.VE", "XKF1.VD")},
           {"velocity", velocities("NKF1.VN", "NKF1.VE", "NKF1.VD")},
           {"position", positions("XKF1.PN", "XKF1.PE", "XKF1.PD")},
           {"position", positions("NKF1.PN", "NKF1.PE", "NKF1.PD")}},
          {{"battery", "BAT.Volt"}}};
}

/// @param known_by the column of the attitude; all groups but the attitude are the same for all bags.
Dialect bag(const char* name, const char* known_by, const char* time, std::vector<MapEntry> attitude) {
  return {
      name,
      known_by,
      time,
      "nwu_flu",
      {{"attitude", std::move(attitude)},
       {"sticks", sticks("/dji_sdk/rc.axes[0]", "/dji_sdk/rc.axes[1]", "/dji_sdk/rc.axes[3]", "/dji_sdk/rc.axes[2]",
                         "scale = 660")},
       {"sticks", sticks("<Joy>.axes[0]", "<Joy>.axes[1]", "<Joy>.axes[3]", "<Joy>.axes[2]", "scale = 660")},
       {"rates", rates("<Imu>.angular_velocity.x", "<Imu>.angular_velocity.y", "<Imu>.angular_velocity.z")},
       {"force", forces("<Imu>.linear_acceleration.x", "<Imu>.linear_acceleration.y", "<Imu>.linear_acceleration.z")},
       {"velocity",
        velocities("/dji_sdk/velocity.vector.x", "/dji_sdk/velocity.vector.y", "/dji_sdk/velocity.vector.z")},
       {"velocity",
        velocities("<TwistStamped>.twist.linear.x", "<TwistStamped>.twist.linear.y", "<TwistStamped>.twist.linear.z")},
       {"position",
        positions("<PoseStamped>.pose.position.x", "<PoseStamped>.pose.position.y", "<PoseStamped>.pose.position.z")},
       {"position",
        positions("<TransformStamped>.transform.translation.x", "<TransformStamped>.transform.translation.y",
                  "<TransformStamped>.transform.translation.z")},
       {"position", positions("<Odometry>.pose.pose.position.x", "<Odometry>.pose.pose.position.y",
                              "<Odometry>.pose.pose.position.z")},
       {"position", positions("/dji_sdk/local_position.point.x", "/dji_sdk/local_position.point.y",
                              "/dji_sdk/local_position.point.z")}},
      {}};
}

Dialect published_mat() {
  return {"the published MAT-files",
          "Experiment1.RCData.channel[1]",
          "Experiment1.Vicon.t",
          "nwu_flu",
          {{"sticks", sticks("Experiment1.RCData.channel[2]", "Experiment1.RCData.channel[1]",
                             "Experiment1.RCData.channel[3]", "Experiment1.RCData.channel[4]", "offset = -1024")},
           {"attitude", three("attitude_roll", "Experiment1.rpy[1]", "attitude_pitch", "Experiment1.rpy[2]",
                              "attitude_yaw", "Experiment1.rpy[3]")},
           {"rates", rates("Experiment1.Vicon.w[1]", "Experiment1.Vicon.w[2]", "Experiment1.Vicon.w[3]")},
           {"velocity", {{"velocity_z", "Experiment1.Vicon.v[3]"}}}},
          {}};
}

Dialect measured_csv() {
  return {"the measured flights as CSV",
          "rc_roll",
          "t_s",
          "nwu_flu",
          {{"sequence", {{"sequence", "seq"}}},
           {"sticks", sticks("rc_roll", "rc_pitch", "rc_throttle", "rc_yaw", "offset = -1024")},
           {"attitude", three("attitude_roll", "odom_roll_rad", "attitude_pitch", "odom_pitch_rad", "attitude_yaw",
                              "odom_yaw_rad")},
           {"attitude", three("attitude_roll", "mocap_roll_rad", "attitude_pitch", "mocap_pitch_rad", "attitude_yaw",
                              "mocap_yaw_rad")},
           {"rates", rates("odom_wx_rad_s", "odom_wy_rad_s", "odom_wz_rad_s")},
           {"rates", rates("imu_wx_rad_s", "imu_wy_rad_s", "imu_wz_rad_s")},
           {"position", positions("mocap_px_m", "mocap_py_m", "mocap_pz_m")},
           {"velocity", velocities("mocap_vx_m_s", "mocap_vy_m_s", "mocap_vz_m_s")},
           {"velocity", {{"velocity_z", "odom_vz_m_s"}}},
           {"force", forces("imu_fx_m_s2", "imu_fy_m_s2", "imu_fz_m_s2")}},
          {}};
}

/// The CSV that `convert` writes, with canonical names.
Dialect canonical_csv(const char* known_by) {
  Dialect out{"canonical names", known_by, "t_s", "nwu_flu", {}, {}};
  for (const std::string_view name : kSignalNames) {
    out.groups.push_back({name.data(), {{name.data(), name.data()}}});
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
          bag("a DJI bag", "/dji_sdk/attitude.quaternion.w", "/dji_sdk/attitude.time",
              attitude_q("/dji_sdk/attitude.quaternion.w", "/dji_sdk/attitude.quaternion.x",
                         "/dji_sdk/attitude.quaternion.y", "/dji_sdk/attitude.quaternion.z")),
          bag("a ROS bag", "<QuaternionStamped>.quaternion.w", "<QuaternionStamped>.time",
              attitude_q("<QuaternionStamped>.quaternion.w", "<QuaternionStamped>.quaternion.x",
                         "<QuaternionStamped>.quaternion.y", "<QuaternionStamped>.quaternion.z")),
          bag("a ROS bag", "<PoseStamped>.pose.orientation.w", "<PoseStamped>.time",
              attitude_q("<PoseStamped>.pose.orientation.w", "<PoseStamped>.pose.orientation.x",
                         "<PoseStamped>.pose.orientation.y", "<PoseStamped>.pose.orientation.z")),
          bag("a ROS bag", "<Odometry>.pose.pose.orientation.w", "<Odometry>.time",
              attitude_q("<Odometry>.pose.pose.orientation.w", "<Odometry>.pose.pose.orientation.x",
                         "<Odometry>.pose.pose.orientation.y", "<Odometry>.pose.pose.orientation.z")),
          bag("a ROS bag", "<Imu>.orientation.w", "<Imu>.time",
              attitude_q("<Imu>.orientation.w", "<Imu>.orientation.x", "<Imu>.orientation.y", "<Imu>.orientation.z"))};
}

}  // namespace m100::lab::logs
