// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "firmware/core/eigen.h"
#include "firmware/core/time.h"
#include "firmware/est/consistency/climb_consistency.h"
#include "firmware/est/consistency/consistency_check.h"
#include "firmware/est/consistency/force_consistency.h"
#include "firmware/est/consistency/heading_consistency.h"
#include "firmware/est/consistency/path_monitor.h"
#include "firmware/est/consistency/specific_force.h"
#include "firmware/est/estimate.h"
#include "firmware/est/imu_sample.h"
#include "firmware/est/measurement.h"

namespace m100::est {

/// Compares the motion of the poses, as the observer estimates it, with the motion that the autopilot measures: four
/// checks, each with its hypothesis and bounds in its own file.
///
///   force    change of horizontal velocity, against the specific force (ForceConsistency)
///   climb    climb speed, against the autopilot's (ClimbConsistency)
///   heading  change of heading, against the autopilot's and its gyroscopes (HeadingConsistency)
///   motion   the path of the last seconds, against that of the specific force (PathMonitor)
///
/// The autopilot's horizontal velocity is not used: it drifts, and reads zero for more than a third of the time. No
/// evidence is added while no pose was used for 0.3 s, while the force has stopped, or to a check whose measurement
/// does not come.
///
/// No heap. Cost: thirteen square roots and about 220 products a tick, plus the shared sines and cosines of attitude
/// and heading. T is float or double.
template <typename T>
class VelocityConsistency {
 public:
  /// @param off checks that the operator has switched off.
  explicit VelocityConsistency(CheckSet off = 0) : disabled_checks_(off) {}

  /// Once per tick, after the observer.
  /// @param disturbance_acceleration_w_m_s2 acceleration by wind (world), learned while the poses were trusted
  void update(const ImuSample<T>& imu, const Estimate<T>& estimate,
              const core::Vector<T, 2>& disturbance_acceleration_w_m_s2, core::Duration elapsed);

  const Contradiction<T>& report() const { return report_; }
  /// Whether the force has been compared with the poses for two seconds, or cannot be compared: its unit is not known,
  /// it never came, or its check is off. False without end if the force stops before it was compared for so long.
  bool is_converged() const {
    return force_scale_m_s2() == T(0) || is_disabled(ConsistencyCheck::kForce) || specific_force_.learned_s() >= T(2);
  }
  /// Unit of the newest specific force in m/s^2; zero if it is not known or the force contains no gravity.
  T force_scale_m_s2() const { return specific_force_.scale_m_s2(); }
  const Vibration<T>& vibration() const { return paths_.vibration(); }
  const LeverArmFit<T>& lever_arm() const { return paths_.lever_arm(); }
  /// See HeadingConsistency.
  T heading_turned_alone_rad() const { return heading_.turned_alone_rad(); }
  /// The force disagrees by more than is allowed, or the path has more than half of the evidence for an alarm.
  bool is_suspect() const { return suspect_; }
  /// Measured horizontal acceleration, averaged over kForceMean_s, without the sensor's error: forward and left of the
  /// heading. nullopt: the motion of this tick was not observed, or no force of a known unit was compared with the
  /// poses yet.
  std::optional<core::Vector<T, 2>> measured_h_m_s2() const {
    return is_observed_ && specific_force_.learned_s() > T(0)
               ? std::optional<core::Vector<T, 2>>(specific_force_.mean_h_m_s2())
               : std::nullopt;
  }
  /// The largest recent acceleration, without the rotors' vibration.
  T moved_m_s2() const { return specific_force_.moved_m_s2(); }
  /// The disturbance acceleration. Its is_known is false until the sensor's error was learned for 3 s, while the force
  /// or the observer's prediction is missing, and if the check of the force is off.
  const DisturbanceAcceleration<T>& disturbance_acceleration() const { return disturbance_acceleration_; }

 private:
  bool is_disabled(ConsistencyCheck check) const { return (disabled_checks_ & set_of(check)) != 0; }
  bool is_sane() const;
  void reset_sums();
  void update_force(const ImuSample<T>& imu, const Estimate<T>& estimate, core::Duration elapsed);
  void update_disturbance(const core::SinCos<T>& yaw, bool is_known, T step_s);
  void judge(ConsistencyCheck check, CheckEvidence<T>& evidence, T step_s);
  void report_if(bool contradicts, const Contradiction<T>& found);

  CheckSet disabled_checks_;
  bool suspect_ = false;  ///< is_suspect(): the effect of a sensor fault must not be learned as the sensor's error
  core::Duration force_age_{0};
  bool is_observed_ = false;  ///< telemetry showed the motion of this tick; true while no force has ever come
  SpecificForce<T> specific_force_;
  ForceConsistency<T> force_;
  ClimbConsistency<T> climb_;
  HeadingConsistency<T> heading_;
  PathMonitor<T> paths_;
  DisturbanceAcceleration<T> disturbance_acceleration_;
  Contradiction<T> report_;
};

extern template class VelocityConsistency<float>;
extern template class VelocityConsistency<double>;

}  // namespace m100::est
