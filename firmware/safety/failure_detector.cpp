// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/safety/failure_detector.h"

#include <array>

#include "firmware/core/maths.h"

namespace m100::safety {
namespace {

constexpr double kMaxTilt_cos = 0.70710678118654752, kTilted_s = 0.1;
constexpr double kVerticalMemory_s = 0.5;
constexpr double kTumbling_rad_s = 2.0 * core::kPi, kTumbling_s = 0.25;
constexpr double kFreeFall_g = 0.2, kFreeFall_s = 0.3, kFalling_m_s = 0.5 * 9.8066 * kFreeFall_s;
constexpr double kMaxLean_rad = core::kPi / 6.0, kLeaning_s = 2.0;
/// A crash is a force above kShock_g, and then kStill_s without motion within kShockMemory_s. A flying aircraft that
/// removes the speed by such a blow turns faster than kStill_rad_s.
constexpr double kShock_g = 3.0, kStill_rad_s = 0.1, kStill_m_s = 0.1, kStill_s = 1.0, kShockMemory_s = 3.0;
/// White noise does not reach so many of its sigmas in a flight.
constexpr double kVibrationSigmas = 6.0;
constexpr double kLongest_s = 100.0;
constexpr double kMaxRate_rad_s = 100.0;  ///< larger than any gyro's range

constexpr std::array<std::string_view, 5> kNames{"none", "tilt", "tumbling", "free_fall", "crash"};

template <typename T>
core::Vector<T, 3> cross(const core::Vector<T, 3>& a, const core::Vector<T, 3>& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x()};
}

/// Updates the time for which a condition has held without interruption.
template <typename T>
void count(T& lasts_s, bool holds, T step_s) {
  lasts_s = holds ? core::clamp(lasts_s + step_s, T(0), static_cast<T>(kLongest_s)) : T(0);
}

}  // namespace

std::string_view name(FlightFailure failure) { return kNames[static_cast<std::size_t>(failure)]; }

template <typename T>
void FailureDetector<T>::update_vertical(const FlightSample<T>& sample, T step_s) {
  if (!sample.up_b) {
    return;
  }
  const Vector3& reported = *sample.up_b;
  const Vector3& rate = sample.rate_b_rad_s;
  const T rate2 = rate.squaredNorm();
  const bool sane = rate2 < static_cast<T>(kMaxRate_rad_s * kMaxRate_rad_s) && up_b_.squaredNorm() < T(2);
  if (!begun_ || !sane || step_s > static_cast<T>(kTilted_s)) {
    up_b_ = reported;
  } else {
    up_b_ += cross(up_b_, rate) * step_s + (reported - up_b_) * (step_s * static_cast<T>(1.0 / kVerticalMemory_s));
    up_b_ *= T(1) / core::sqrt(up_b_.squaredNorm());
  }
  begun_ = true;
  turn_rad_s_ = sane ? core::sqrt(rate2) : T(0);
  reported_up_ = reported.z();
  agrees_ = up_b_.dot(reported) > static_cast<T>(kMaxTilt_cos);
}

template <typename T>
void FailureDetector<T>::update_shock(const FlightSample<T>& sample, T step_s) {
  const T climbs_m_s = climb_m_s_ < T(0) ? -climb_m_s_ : climb_m_s_;
  const bool still =
      climb_known_ && turn_rad_s_ < static_cast<T>(kStill_rad_s) && climbs_m_s < static_cast<T>(kStill_m_s);
  count(since_shock_s_, true, step_s);
  count(still_s_, still, step_s);
  if (sample.force_g && force_g_ > static_cast<T>(kShock_g)) {
    const T earlier_g = since_shock_s_ < static_cast<T>(kShockMemory_s) ? shock_g_ : T(0);
    shock_g_ = force_g_ > earlier_g ? force_g_ : earlier_g;
    since_shock_s_ = still_s_ = T(0);
  }
  if (still_s_ == T(0)) {
    still_square_ = still_forces_ = T(0);
  } else if (sample.force_g) {
    still_square_ += (force_g_ - T(1)) * (force_g_ - T(1));
    still_forces_ += T(1);
  }
}

template <typename T>
FlightFailure FailureDetector<T>::update(const FlightSample<T>& sample, T step_s) {
  update_vertical(sample, step_s);
  force_g_ = sample.force_g.value_or(force_g_);
  climb_known_ = climb_known_ || sample.climb_m_s.has_value();
  climb_m_s_ = sample.climb_m_s.value_or(climb_m_s_);
  const bool trusted = begun_ && sample.attitude_is_trusted;
  count(tilted_s_, trusted && reported_up_ < static_cast<T>(kMaxTilt_cos) && up_b_.z() < static_cast<T>(kMaxTilt_cos),
        step_s);
  count(tumbling_s_, trusted && agrees_ && turn_rad_s_ > static_cast<T>(kTumbling_rad_s), step_s);
  count(falling_s_, force_g_ < static_cast<T>(kFreeFall_g), step_s);
  count(leaning_s_, trusted && sample.lean_rad > static_cast<T>(kMaxLean_rad), step_s);
  update_shock(sample, step_s);
  if (tilted_s_ >= static_cast<T>(kTilted_s)) {
    return FlightFailure::kTilt;
  }
  if (tumbling_s_ >= static_cast<T>(kTumbling_s)) {
    return FlightFailure::kTumbling;
  }
  if (falling_s_ >= static_cast<T>(kFreeFall_s) && (!climb_known_ || climb_m_s_ < static_cast<T>(-kFalling_m_s))) {
    return FlightFailure::kFreeFall;
  }
  const T blow_g = shock_g_ - T(1);
  const bool shocked =
      since_shock_s_ < static_cast<T>(kShockMemory_s) && still_s_ >= static_cast<T>(kStill_s) &&
      blow_g * blow_g * still_forces_ >= static_cast<T>(kVibrationSigmas * kVibrationSigmas) * still_square_;
  return leaning_s_ >= static_cast<T>(kLeaning_s) || shocked ? FlightFailure::kCrash : FlightFailure::kNone;
}

template class FailureDetector<float>;
template class FailureDetector<double>;

}  // namespace m100::safety
