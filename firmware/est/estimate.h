// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/cached_sin_cos.h"
#include "firmware/core/maths.h"
#include "firmware/core/time.h"
#include "firmware/est/estimate_status.h"

namespace m100::est {

/// Bound of the specific force's offset that is still unknown after the first seconds of a flight.
inline constexpr double kForceOffset_m_s2 = 0.2;

/// One horizontal axis of the yaw-free world frame. Axis x moves by pitch: x'' = +g tan(tilt). Axis y moves by roll:
/// y'' = -g tan(tilt). T is float or double.
template <typename T>
struct AxisEstimate {
  T position_m{0};
  T velocity_m_s{0};
  T tilt_rad{0};  ///< pitch (x) or roll (y), turned into the yaw-free frame
  T tilt_rate_rad_s{0};
  T disturbance_m_s2{0};  ///< acts as an acceleration: wind, unmodelled drag
  T input_offset_rad{0};  ///< acts at the input: errors of trim and command gain (estimated as an angle)
  // The observer's own estimate of its errors. The variances include the uncertainty of the poses' time of capture.
  T position_variance_m2{0};
  T filter_variance_m2{0};      ///< of the position, without CovarianceInflation
  T position_velocity_m2_s{0};  ///< covariance of position and velocity
  T velocity_variance_m2_s2{0};
  T measured_tilt_rad{0};  ///< the newest attitude that was used, without the model
};

/// The last pose that the gate refused, for messages and the log.
template <typename T>
struct Refusal {
  T distance_m{0};  ///< from the prediction, along the axis with the largest ratio of distance to gate
  T allowed_m{0};
  T turned_rad{0};  ///< from the predicted heading
};

/// The state at the present tick: all that the control law may use.
template <typename T>
struct Estimate {
  AxisEstimate<T> x;
  AxisEstimate<T> y;
  T height_m{0};
  T climb_m_s{0};
  T pose_height_variance_m2{0};           ///< of the height at the newest pose that was used
  T climb_offset_m_s{0};                  ///< steady flown minus commanded climb speed
  T height_gain{0}, climb_gain_per_s{0};  ///< Kalman gains of the newest pose that was used
  T yaw_rad{0};
  T yaw_rate_rad_s{0};
  core::Duration pose_age{0};       ///< of the newest pose that was used
  std::uint32_t refused_poses = 0;  ///< by the innovation gate, in a row
  core::Duration refused_for{0};    ///< from the first arrival to the last, of the refused poses that agree in a row
  Refusal<T> refusal;
  bool prediction_valid = false;   ///< the filter runs and has settled, and the attitude is known
  bool healthy = false;            ///< prediction_valid, and a pose was used in the last second
  bool attitude_is_known = false;  ///< the newest used one is at most 0.45 s old (0.1 s if newer ones were refused)
  mutable core::CachedSinCos<T> heading_sin_cos{};

  /// Sine and cosine of the yaw, computed once for all callers.
  const core::SinCos<T>& heading() const { return heading_sin_cos.of(yaw_rad); }
};

/// What the supervisor needs to know of the estimate.
template <typename T>
EstimateStatus status_of(const Estimate<T>& estimate) {
  constexpr T kErrorSigmas = T(3);
  const T variance_m2 =
      core::clamp(estimate.x.position_variance_m2, estimate.y.position_variance_m2, T(1e6));  // the larger
  return {.pose_age = estimate.pose_age,
          .error_m = static_cast<double>(kErrorSigmas * core::sqrt(variance_m2)),
          .healthy = estimate.healthy};
}

}  // namespace m100::est
