// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>

#include "firmware/model/axis_step.h"

#include "host_tests/lab/gains/gain_tables.h"
#include "host_tests/lab/gains/margins.h"

namespace m100::lab::gains {

/// The state after one step of the predictor's model.
Eigen::VectorXd step_state(const mpc::StepModel<double>& model, const Eigen::VectorXd& state, double input,
                           double disturbance);

/// The flight law of one axis with its observer, linear about hover, from a vehicle file (from its design, if it has
/// one). It does not depend on the aircraft that it flies.
struct FlownController {
  FlownController(const model::Vehicle& identified, Axis axis, const LoopTiming& timing);

  using Square = Eigen::Matrix<double, 6, 6>;
  using Six = Eigen::Matrix<double, 6, 1>;
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

  /// The measurements that arrive in a tick, as old as LoopTiming states.
  struct Seen {
    double position_m = 0.0;
    double tilt_rad = 0.0;
    double rate_rad_s = 0.0;
  };
  /// The stick scale of `truth` over the one that the law assumes; 1 without sticks, or if a scale is not known.
  double stick_gain(const model::StickAxis& truth, const LoopTiming& timing) const;
  /// Size of the state that tick() keeps.
  Eigen::Index own_states(const LoopTiming& timing) const;
  /// One tick of observer, prediction and law. @param sends the command leaves in this tick
  /// @returns the command of the law
  double tick(Eigen::Ref<Eigen::VectorXd> own, const Seen& seen, bool sends, const LoopTiming& timing) const;

 private:
  double law(const Eigen::VectorXd& commands, const Six& estimate) const;
};

/// The controller alone, lifted over one command period: x(k+1) = a x + b y, u = c x + d y, with y = (position, tilt,
/// rate) as they arrive in the ticks of the period, and u the command that leaves in its first tick.
struct LiftedController {
  LiftedController(const FlownController& controller, const LoopTiming& timing);
  /// c (z - a)^-1 b + d.
  Eigen::RowVectorXcd response(std::complex<double> z) const;

  Eigen::MatrixXd a, b;
  Eigen::VectorXd c, d;
};

/// The loop as flown, opened at the attitude command. Input: the command that the vehicle gets and holds until the next
/// one. Output: the command that the controller would have sent. One step of this system is one command period.
class FlownLoop {
 public:
  using Dense = Eigen::MatrixXd;
  using Column = Eigen::VectorXd;

  FlownLoop(const FlownController& controller, const model::Vehicle& truth, Axis axis, const LoopTiming& timing);

  /// Frequency response from the vehicle's command to the controller's, at z = exp(i w period).
  std::complex<double> response(double frequency_rad_s) const;
  bool closed_is_stable() const;
  double period_s() const { return period_s_; }

 private:
  struct Parts;
  double tick(Column& state, const Parts& parts, bool sends, double vehicle_input) const;

  const FlownController& controller_;
  LoopTiming timing_;
  // The vehicle: x(k+1) = a x + early u(k-n-1) + late u(k-n); tilt and rate as its attitude sensor sees them.
  Dense a_;
  Column early_, late_;
  Eigen::RowVectorXd tilt_, rate_;
  double tilt_per_input_ = 0.0, rate_per_input_ = 0.0;
  Eigen::Index line_ = 1;  ///< commands in the delay line, n + 1
  double period_s_ = 0.0;
  Dense loop_;
  Column in_, out_;
};

}  // namespace m100::lab::gains
