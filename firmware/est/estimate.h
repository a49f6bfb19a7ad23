// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/standing_turn.h"
#include "firmware/core/time.h"

namespace m100::est {

/// The most of the force's offset that is not yet known after its first seconds (measured logs: a few tenths).
inline constexpr double kForceOffset_m_s2 = 0.2;

/// One horizontal axis of the yaw-free world frame. Axis x moves by pitch: x'' = +g tan(tilt); axis y by roll:
/// y'' = -g tan(tilt). T is float or double whatever the filter computes in.
template <typename T>
struct AxisEstimate {
  T position_m{0};
  T velocity_m_s{0};
  T tilt_rad{0};  ///< pitch (x) or roll (y), turned into the yaw-free frame
  T tilt_rate_rad_s{0};
  T disturbance_m_s2{0};  ///< what acts as an acceleration: wind, drag the model lacks
  T input_offset_rad{0};  ///< what acts at the input: trim and command-gain errors (estimated as an angle)
  // How far position and velocity may be from the truth, by the observer's own account; the uncertainty of the poses'
  // time of capture is in it.
  T position_variance_m2{0};
  T filter_variance_m2{0};      ///< of the position, by the filter alone: what poses push it by adds nothing to it
  T position_velocity_m2_s{0};  ///< covariance of the two
  T velocity_variance_m2_s2{0};
};

/// The last pose that the gate refused, for people.
template <typename T>
struct Refusal {
  T distance_m{0};  ///< from where it had to be, along the axis that it was farthest beyond its gate
  T allowed_m{0};
  T turned_rad{0};  ///< from the heading that it had to have
};

/// The state at the present tick: everything the control law may look at.
template <typename T>
struct Estimate {
  AxisEstimate<T> x;
  AxisEstimate<T> y;
  T height_m{0};
  T climb_m_s{0};
  T climb_offset_m_s{0};  ///< steady difference between commanded and flown climb speed
  T yaw_rad{0};
  T yaw_rate_rad_s{0};
  core::Duration pose_age{0};       ///< of the newest pose that was used
  std::uint32_t refused_poses = 0;  ///< by the innovation gate, in a row
  core::Duration refused_for{0};    ///< from the first to the last of those that agree with each other
  Refusal<T> refusal;
  bool predicts = false;  ///< begun and settled, the attitude known: the model's prediction stands
  bool healthy = false;   ///< and a pose was used in the last second
  mutable core::StandingTurn<T> heading_turn{};

  /// Sine and cosine of the yaw, taken once for all who ask.
  const core::Turn<T>& heading() const { return heading_turn.of(yaw_rad); }
};

}  // namespace m100::est
