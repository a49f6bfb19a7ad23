// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/core/eigen.h"
#include "firmware/core/maths.h"
#include "firmware/core/time.h"
#include "firmware/est/consistency/consistency_check.h"
#include "firmware/est/consistency/cusum.h"
#include "firmware/est/consistency/path_consistency.h"
#include "firmware/est/estimate.h"
#include "firmware/est/imu_sample.h"
#include "firmware/est/measurement.h"

namespace m100::est {

/// Compares the motion of the poses, as the observer estimates it, with the motion that the autopilot measures.
///
///   force    g' = v_pose' - (f + o) - g / 2 s   v_pose: the observer's velocity; f: the specific force turned into
///                                               the world; o: its constant error, learned over 20 s
///   climb    c = climb_pose - climb_autopilot
///   heading  h = (yaw_pose - yaw_autopilot) less its mean over 5 s
///   motion   the path of the last seconds: PathConsistency, with evidence of its own
///
/// Each of the first three is weighed by its allowed value and summed (Cusum). The source explains each bound.
///
/// The autopilot's horizontal velocity is not used: it reads zero for more than a third of the time, and otherwise
/// starts again at zero and drifts by 0.4 m/s per root of a second, which hides what the specific force shows. Nothing
/// is judged while no pose was used for 0.3 s, or while a part of telemetry is missing; poses that the gate begins to
/// refuse do not reduce the evidence. If the mean length of the acceleration is neither 1 g nor 9.8 m/s^2, gravity has
/// been removed from it, and it is no evidence.
///
/// No heap. Cost: twelve square roots and about 220 products a tick, plus the shared sines and cosines of attitude
/// and heading. T is float or double.
template <typename T>
class VelocityConsistency {
 public:
  /// @param off checks that the operator has switched off.
  explicit VelocityConsistency(CheckSet off = 0) : disabled_checks_(off) {}

  /// Once per tick, after the observer.
  /// @param disturbance_acceleration_w_m_s2 acceleration by wind in the world while everything still agreed
  /// (DeadReckoning)
  void update(const ImuSample<T>& imu, const Estimate<T>& estimate,
              const core::Vector<T, 2>& disturbance_acceleration_w_m_s2, core::Duration elapsed);

  const Contradiction<T>& report() const { return report_; }
  /// The force has been compared with the poses for two seconds (or does not come, or its check is off). A pose that
  /// moves without the force showing it has been detected by then.
  bool is_converged() const {
    return force_scale_m_s2_ == T(0) || (disabled_checks_ & set_of(ConsistencyCheck::kForce)) != 0 ||
           force_seen_s_ >= T(2);
  }
  /// Unit of the newest specific force in m/s^2; zero: it is not known, or gravity is not in it.
  T force_scale_m_s2() const { return force_scale_m_s2_; }
  /// Force or path disagree by more than is allowed, but not yet for long enough to raise the alarm.
  bool is_suspect() const { return suspect_; }
  /// Measured horizontal acceleration, averaged over kForceMean_s, without the offset: forward and left of the heading.
  /// nullopt: the force does not come, or its unit is not known.
  std::optional<core::Vector<T, 2>> measured_h_m_s2() const {
    return force_seen_s_ > T(0) ? std::optional<core::Vector<T, 2>>(measured_h_m_s2_) : std::nullopt;
  }
  /// The largest recent acceleration, without the rotors' vibration.
  T moved_m_s2() const { return moved_m_s2_; }
  /// The push; not known where the force does not come or the operator has switched its check off.
  const DisturbanceAcceleration<T>& disturbance_acceleration() const { return disturbance_acceleration_; }

 private:
  using Vector2 = core::Vector<T, 2>;
  /// Nothing is summed before this time, in which the observer settles after its start.
  static constexpr double kBegins_s = 1.0;
  static constexpr core::Duration kPoseUsed = std::chrono::milliseconds(300);

  void update_specific_force(const ImuSample<T>& imu);
  bool is_sane() const;
  void reset_sums();
  void update_disturbance(const core::SinCos<T>& yaw, bool is_known, T step_s);
  T velocity_residual(const Estimate<T>& estimate, const core::SinCos<T>& yaw, T step_s);
  Vector2 accelerometer_bias_h_m_s2() const;
  T vertical_acceleration_m_s2() const;
  void estimate_vertical_bias(T climbed_m_s, T most_m_s, T share, T step_s);
  T heading_residual(const ImuSample<T>& imu, const Estimate<T>& estimate, T step_s);
  void update_start_sigma(const Estimate<T>& estimate);
  T allowed_m_s(const Vector2& disturbance_acceleration_w_m_s2) const;
  bool recovers_from_gap(const Estimate<T>& estimate, T step_s);
  void update_paths(const ImuSample<T>& imu, const Estimate<T>& estimate, const core::SinCos<T>& yaw, T step_s);
  void update_jolt(const ImuSample<T>& imu, T step_s);
  void estimate_noise(const ImuSample<T>& imu, const Estimate<T>& estimate, bool used, T step_s);
  void update_horizontal_path(const Estimate<T>& estimate, const Vector2& force_w_m_s2, bool pose_used, T step_s);
  void update_vertical_path(const Estimate<T>& estimate, T vertical_acceleration_m_s2, bool pose_used, T step_s);
  void restart_paths() {
    horizontal_path_.restart();
    vertical_path_.restart();
  }
  T path_statistic() const;
  void accumulate(ConsistencyCheck check, T disagreement, T allowed, T step_s);

  CheckSet disabled_checks_;
  T force_scale_m_s2_{0};  ///< of one unit of the newest force; zero: its unit is not known
  bool velocity_known_ = false;
  bool heading_known_ = false;
  T start_sigma_m_s_{10};  ///< of the velocity beyond calm air, the least since the start
  bool suspect_ = false;   ///< more than is allowed: the effect of a sensor fault must not be learned as an offset
  T force_seen_s_{0};      ///< how long the offset has been learned; at most its memory
  T force_size_{0};        ///< mean length of the acceleration, as sent
  Vector2 force_h_m_s2_ = Vector2::Zero();                   ///< newest specific force, forward and left, horizontal
  T lifted_m_s2_{0};                                         ///< the same upward, without gravity
  Vector2 tilt_acceleration_h_m_s2_ = Vector2::Zero();       ///< acceleration by tilt at the same time
  Vector2 mean_tilt_acceleration_h_m_s2_ = Vector2::Zero();  ///< mean of tilt_acceleration_h_m_s2_ over a second
  DisturbanceAcceleration<T> disturbance_acceleration_;
  Vector2 offset_h_m_s2_ = Vector2::Zero();    ///< constant error of the force: body x and y
  T offset_up_m_s2_{0};                        ///< constant error of the force: body z
  Vector2 measured_h_m_s2_ = Vector2::Zero();  ///< the force without offset and vibration
  T moved_m_s2_{0};                            ///< its largest value in the last second, fading
  Vector2 velocity_w_m_s_ = Vector2::Zero();   ///< in the tick before
  T climb_m_s_{0};                             ///< likewise
  Vector2 velocity_residual_w_m_s_ = Vector2::Zero();
  T summed_s_{0};  ///< over how long velocity_residual_w_m_s_ is a sum
  T heading_offset_rad_{0};
  std::array<Cusum<T>, kCheckCount> cusum_;
  PathConsistency<T> horizontal_path_;
  bool vertical_turn_ = false;  ///< the height is followed in this tick, in the next one the horizontal path
  Vector2 force_before_w_m_s2_ = Vector2::Zero();  ///< in the tick before
  T vertical_before_m_s2_{0};
  PathConsistency<T, 1> vertical_path_;  ///< motion_ for the height
  /// White noise, from neighbouring samples: slow changes by a sensor fault or a motion do not add to it.
  struct Noise {
    core::Vector<T, 3> before = core::Vector<T, 3>::Zero();
    T level{0};  ///< mean square of one horizontal axis
    T up{0};     ///< mean square of the vertical axis
    void add(const core::Vector<T, 3>& now, T weight, T share);
  };
  Noise force_noise_;     ///< density, m^2/s^3
  Noise position_noise_;  ///< corrections of the observer's position by poses per tick, m^2
  core::Vector<T, 3> position_w_m_ = core::Vector<T, 3>::Zero();  ///< in the tick before
  T force_age_s_{0};
  T since_correction_s_{0};  ///< since the last correction by a pose
  T measured_climb_m_s_{0};  ///< newest climb speed of the autopilot
  T measured_gain_m_s_{0};   ///< change of climb speed since then, by the force
  T jolt_m_s_{0};            ///< largest change beyond that, since the height was judged
  T gap_recovery_s_{0};      ///< for how long poses still correct what the observer predicted without them
  T last_age_s_{0};
  T unused_s_{0};  ///< since a pose was used
  Contradiction<T> report_;
};

extern template class VelocityConsistency<float>;
extern template class VelocityConsistency<double>;

}  // namespace m100::est
