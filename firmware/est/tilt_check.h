// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/est/evidence.h"
#include "firmware/est/felt.h"

namespace m100::est {

/// Holds the autopilot's attitude against the autopilot's rates. No pose is needed, and none is contradicted.
///
///   e' = tilt' - what the rates make of it - e / 0.25 s     roll and pitch together
///
/// |e| is weighed by what is allowed and summed (Evidence); the bounds stand in the source. A tilt that stands still,
/// is in other units or has other axes than its rates is found; where both are wrong alike, nothing is.
///
/// Fifteen numbers; no heap. Cost: three square roots and about 40 products an attitude, beside the sines of its
/// angles, which all that look at it share. T is float or double.
template <typename T>
class TiltCheck {
 public:
  /// Once per tick.
  void update(const Felt<T>& felt, T step_s);

  /// Attitude and rates contradict each other.
  bool contradicts() const { return evidence_.suffices(); }
  /// By how much they differ, and what is allowed; rad.
  T apart_rad() const { return apart_rad_; }
  T allowed_rad() const { return allowed_rad_; }

 private:
  using Vector2 = core::Vector<T, 2>;

  T age_s_{1};                                 ///< how long ago the newest attitude came
  Vector2 tilt_rad_ = Vector2::Zero();         ///< roll and pitch of the newest attitude
  Vector2 tilt_rate_rad_s_ = Vector2::Zero();  ///< what its rates make of them
  Vector2 unturned_rad_ = Vector2::Zero();     ///< tilt that was gained without the rates, leaky
  Vector2 turned_rad_ = Vector2::Zero();       ///< with them, likewise
  T fastest_rad_s_{0};                         ///< of the rates, lately
  T farthest_rad_{0};                          ///< of turned_rad_, lately
  Evidence<T> evidence_;
  T apart_rad_{0};
  T allowed_rad_{0};
};

extern template class TiltCheck<float>;
extern template class TiltCheck<double>;

}  // namespace m100::est
