// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "firmware/core/eigen.h"
#include "firmware/safety/flight_state.h"

namespace m100::safety {

/// Inputs of FailureDetector in one tick. A measurement that did not come is empty.
template <typename T>
struct FlightSample {
  using Vector3 = core::Vector<T, 3>;
  std::optional<Vector3> up_b = std::nullopt;  ///< the world's vertical in body axes (FLU), by the autopilot's attitude
  Vector3 rate_b_rad_s = Vector3::Zero();      ///< FLU; read where up_b is given
  bool attitude_is_trusted = true;             ///< false: FaultIsolation::attitude_is_contradicted()
  T lean_rad{0};                               ///< angle between the tilt and the tilt that model and commands predict
  std::optional<T> force_g = std::nullopt;     ///< length of the specific force, in g
  std::optional<T> climb_m_s = std::nullopt;   ///< by the autopilot
};

/// Detects flights that are out of control, as PX4's failure detector and ArduPilot's crash check do.
///
///   tilt       beyond 45 degrees for 0.1 s; the law and the supervisor command at most 30
///   tumbling   more than one revolution per second for 0.25 s
///   free fall  a specific force below 0.2 g for 0.3 s, and the aircraft sinks at 1.5 m/s or no climb speed has come
///   crash      tilted 30 degrees away from the predicted tilt for 2 s; or a force above 3 g, and in the 3 s after it
///              one second with rates below 0.1 rad/s and a climb speed below 0.1 m/s. The force must exceed 1 g by six
///              times the root mean square of what it differs from 1 g in that second: a vibrating hover has shocks,
///              too, but it goes on vibrating
///
/// A tilt must show in the attitude and in the integral of the body rates; tumbling counts only while these two are
/// within 45 degrees. An attitude that its own rates or our commands contradict is not used. T is float or
/// double. No heap. Cost: about 30 products a tick.
template <typename T>
class FailureDetector {
 public:
  /// Once per tick, `step_s` after the last one.
  FlightFailure update(const FlightSample<T>& sample, T step_s);

 private:
  using Vector3 = core::Vector<T, 3>;
  void update_vertical(const FlightSample<T>& sample, T step_s);
  void update_shock(const FlightSample<T>& sample, T step_s);

  bool begun_ = false;
  Vector3 up_b_ = Vector3::UnitZ();  ///< integrated from the rates, corrected by the attitude
  T reported_up_{1};                 ///< cosine of the newest attitude's tilt
  bool agrees_ = true;               ///< up_b_ with the newest attitude's vertical
  T turn_rad_s_{0};                  ///< magnitude of the newest rates
  T force_g_{1};                     ///< newest, likewise below
  T climb_m_s_{0};
  bool climb_known_ = false;
  T tilted_s_{0}, tumbling_s_{0}, falling_s_{0}, leaning_s_{0}, still_s_{0};
  T since_shock_s_{1e3};
  T shock_g_{0};       ///< largest force of the newest shocks
  T still_square_{0};  ///< sum of (force - 1 g)^2 while it is still, over still_forces_ messages
  T still_forces_{0};
};

extern template class FailureDetector<float>;
extern template class FailureDetector<double>;

}  // namespace m100::safety
