// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/core/frames.h"
#include "host_tests/sim/body/rotor_mixer.h"
#include "host_tests/sim/world/plant.h"

namespace m100::sim {

/// What the loops follow. FLU.
struct BodyCommand {
  double roll_rad = 0.0;
  double pitch_rad = 0.0;
  double climb_m_s = 0.0;
  double yaw_rate_rad_s = 0.0;
};

/// What the autopilot's filters found. FLU.
struct BodyMotion {
  core::Euler<double> attitude{};
  core::Vector<double, 3> rate_b_rad_s = core::Vector<double, 3>::Zero();
  double climb_m_s = 0.0;
  bool in_air = true;  ///< on the ground nothing is learned
};

/// The autopilot's loops for a rigid body with four rotors:
///
///   rate_c = attitude_gain (tilt_c - tilt), in body axes, at most kMaxRate     | yaw rate as commanded
///   acceleration = rate_gain (e + integral of e / T - T_d rate'), e = rate_c - rate  | shared out by the authority;
///                                                          rate' of roll and pitch, below kRateCutoff
///   axis thrust = hover (1 + climb_gain e_v / g) / cos(tilt),  hover' = hover e_v climb_gain / (g T_h)
///
/// Torques count in shares of the hover thrust, which is learned: the loops need not know how strong the rotors are.
class BodyControl {
 public:
  static constexpr double kMaxRate_rad_s = 5.2;  ///< M100's published limit of roll and pitch, 300 degrees a second
  static constexpr double kRateCutoff_rad_s = 188.5;  ///< PX4's IMU_DGYRO_CUTOFF, 30 Hz
  explicit BodyControl(const AutopilotNumbers& numbers) : numbers_(numbers), hover_(numbers.hover_thrust) {}

  /// @returns each rotor's throttle, 0 to 1.
  RotorNumbers update(const BodyCommand& command, const BodyMotion& motion, double step_s);
  /// The learned hover thrust, as a share of full thrust.
  double hover_thrust() const { return hover_; }

 private:
  core::Vector<double, 3> angular_acceleration(const BodyCommand& command, const BodyMotion& motion, double step_s);

  AutopilotNumbers numbers_;
  double hover_;
  core::Vector<double, 3> slow_rate_rad_s_ = core::Vector<double, 3>::Zero();  ///< the rate below kRateCutoff
  core::Vector<double, 3> integral_rad_s_ = core::Vector<double, 3>::Zero();
};

}  // namespace m100::sim
