// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <functional>
#include <optional>

#include "firmware/model/axis_step.h"
#include "host_tests/lab/gains/gain_tables.h"
#include "host_tests/lab/gains/margins.h"

namespace m100::lab::gains {

/// A linear system from one command period to the next: x(k+1) = a x + b u, y = c x + d u.
struct LiftedSystem {
  using Period = std::function<void(Eigen::VectorXd& state, const Eigen::VectorXd& in, Eigen::VectorXd& out)>;
  /// @param period steps the state through the ticks of one period; linear
  LiftedSystem(Eigen::Index states, Eigen::Index inputs, Eigen::Index outputs, const Period& period);

  /// c (z - a)^-1 b + d, by the Schur form of a.
  Eigen::MatrixXcd response(std::complex<double> z) const;

  Eigen::MatrixXd a, b, c, d;

 private:
  Eigen::MatrixXcd schur_, into_, out_of_;  ///< U* a U, U* b and c U
};

/// The flight law of one axis with its observer, linear about hover, from a vehicle file (from its design, if it has
/// one). It does not depend on the aircraft that it flies.
struct FlownController {
  /// @param assumed  what the observer takes for the ages of its measurements
  FlownController(const model::Vehicle& identified, Axis axis, const LoopTiming& assumed);

  using Square = Eigen::Matrix<double, 6, 6>;
  using Six = Eigen::Matrix<double, 6, 1>;
  LoopTiming timing;
  /// The observer est::AxisFilter: states p, v, tilt, rate, disturbance d [m/s^2], input offset m [rad]; steady gains.
  model::AxisStep step;
  double acceleration_per_tilt_m_s2 = 0.0;  ///< acceleration per tilt, with its sign
  double drag_per_s = 0.0;
  double scale_per_count = 0.0;  ///< of the stick [rad/count]; 0: not stated
  Six tilt_gain, rate_gain, pose_gain;
  mpc::DelayModel<double> delay;
  /// Gains of the law's first input u_0 without limits, for a reference of zero.
  Eigen::VectorXd state_gain;
  double disturbance_gain = 0.0;
  double offset_gain = 0.0;
  double previous_gain = 0.0;

  /// From position, tilt and rate as they arrive in the ticks of a period to the command that leaves in its first tick.
  std::optional<LiftedSystem> lifted;

  /// The stick scale of `truth` over the one that the law assumes; 1 without sticks, or if a scale is not known.
  double stick_gain(const model::StickAxis& truth) const;

 private:
  double tick(Eigen::VectorXd& own, const Eigen::Vector3d& seen, bool sends) const;
  double law(const Eigen::VectorXd& commands, const Six& estimate) const;
};

/// One horizontal axis of the aircraft about hover: from the command that arrives in the first tick of a period, and
/// then holds, to position, tilt and rate as they arrive at the controller in its ticks.
LiftedSystem lifted_aircraft(const model::Vehicle& truth, Axis axis, const LoopTiming& timing);

/// The loop as flown, opened at the attitude command. Input: the command that the vehicle gets and holds until the next
/// one. Output: the command that the controller would have sent. One step of this system is one command period.
class FlownLoop {
 public:
  /// @param timing  as it really is; the controller may assume another age of the pose
  FlownLoop(const FlownController& controller, const model::Vehicle& truth, Axis axis, const LoopTiming& timing);

  /// Frequency response from the vehicle's command to the controller's, at z = exp(i w period).
  std::complex<double> response(double frequency_rad_s) const;
  bool closed_is_stable() const;  ///< by powers of the matrix of the closed loop
  double period_s() const { return period_s_; }

 private:
  const LiftedSystem& controller_;
  LiftedSystem aircraft_;
  double stick_gain_ = 1.0;
  double period_s_ = 0.0;
};

}  // namespace m100::lab::gains
