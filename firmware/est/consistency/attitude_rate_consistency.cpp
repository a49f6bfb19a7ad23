// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/attitude_rate_consistency.h"

#include "firmware/core/frames.h"
#include "firmware/core/maths.h"

namespace m100::est {
namespace {

/// After a manoeuvre the autopilot corrects its own attitude, by up to 0.02 rad in a second or two. No rate shows this;
/// a memory of a quarter of a second leaves 0.002 rad of it. Attitude and rates may be two ticks apart in time, and a
/// tenth apart in scale.
constexpr double kCorrected_rad = 0.002, kMemory_s = 0.25, kRatesLate_s = 0.02, kRatesShare = 0.1;
constexpr double kTurnedLately_s = 1.0;
constexpr double kAttitudeGap_s = 0.05;
constexpr double kSane2 = 1e6;  ///< larger and NaN sums are reset: a NaN would never raise an alarm again

constexpr double kShortest_s = 1e-3;  ///< least time between two attitudes that is used as a divisor

template <typename T>
T larger(T a, T b) {
  return a > b ? a : b;
}
template <typename T>
T smaller(T a, T b) {
  return a < b ? a : b;
}

}  // namespace

template <typename T>
void AttitudeRateConsistency<T>::update(const ImuSample<T>& imu, T step_s) {
  age_s_ = core::clamp(age_s_ + step_s, T(0), T(1));
  if (!imu.attitude_is_new) {
    return;
  }
  const T passed_s = age_s_;
  age_s_ = T(0);
  const core::SinCos<T>& roll = imu.roll();
  const core::SinCos<T>& pitch = imu.pitch();
  const T across = roll.sine * imu.rate_b_rad_s.y() + roll.cosine * imu.rate_b_rad_s.z();
  const T level = pitch.cosine > T(0.1) ? pitch.cosine : T(0.1);
  const Vector2 rate_rad_s(imu.rate_b_rad_s.x() + across * pitch.sine / level,
                           roll.cosine * imu.rate_b_rad_s.y() - roll.sine * imu.rate_b_rad_s.z());
  const Vector2 tilt_rad(imu.roll_rad, imu.pitch_rad);
  const Vector2 tilt_change_rad = tilt_rad - tilt_rad_;
  const Vector2 reported_rad = (rate_rad_s + tilt_rate_rad_s_) * (T(0.5) * passed_s);
  tilt_rad_ = tilt_rad;
  tilt_rate_rad_s_ = rate_rad_s;
  const bool sane = unturned_rad_.squaredNorm() + turned_rad_.squaredNorm() + jumped_rad_.squaredNorm() +
                        fastest_rad_s_ * fastest_rad_s_ + farthest_rad_ * farthest_rad_ <
                    static_cast<T>(kSane2);
  if (!sane) {
    fastest_rad_s_ = farthest_rad_ = T(0);
  }
  if (larger(passed_s, imu.since_last_s) > static_cast<T>(kAttitudeGap_s) || !sane) {
    unturned_rad_.setZero();
    turned_rad_.setZero();
    jumped_rad_.setZero();
    return;
  }
  const T fades = passed_s * static_cast<T>(1.0 / kMemory_s);
  unturned_rad_ += tilt_change_rad - reported_rad - unturned_rad_ * fades;
  turned_rad_ += reported_rad - turned_rad_ * fades;
  const T forgets = T(1) - passed_s * static_cast<T>(1.0 / kTurnedLately_s);
  // Only a turn that attitude and rates both show excuses a difference: noisy rates alone do not show a delay. If they
  // are two ticks apart, both still show 0.8 of the peak rate of an oscillation of 10 Hz.
  const T known_s = larger(passed_s, static_cast<T>(kShortest_s));
  const T reported2 = smaller(rate_rad_s.squaredNorm(), tilt_change_rad.squaredNorm() / (known_s * known_s));
  const T turned2 = smaller(turned_rad_.squaredNorm(), (turned_rad_ + unturned_rad_).squaredNorm());
  fastest_rad_s_ = larger(fastest_rad_s_ * forgets, core::sqrt(reported2));
  farthest_rad_ = larger(farthest_rad_ * forgets, core::sqrt(turned2));
  jumped_rad_ *= forgets;
  add_jump(tilt_change_rad - reported_rad, larger(fastest_rad_s_ * fastest_rad_s_, rate_rad_s.squaredNorm()), passed_s);
  weigh(passed_s);
}

/// Sums changes of the tilt beyond the fastest recent rate: a small delay between attitude and rates causes no such
/// change.
template <typename T>
void AttitudeRateConsistency<T>::add_jump(const Vector2& unturned_rad, T fastest2, T passed_s) {
  constexpr T kCorrected = static_cast<T>(kCorrected_rad);
  const T unturned2 = unturned_rad.squaredNorm();
  if (unturned2 > kCorrected * kCorrected) {
    const T explained = (kCorrected + core::sqrt(fastest2) * passed_s) / core::sqrt(unturned2);
    jumped_rad_ += unturned_rad * (T(1) - smaller(explained, T(1)));
  }
}

template <typename T>
void AttitudeRateConsistency<T>::weigh(T passed_s) {
  constexpr T kCorrected = static_cast<T>(kCorrected_rad);
  residual_rad_ = core::sqrt(unturned_rad_.squaredNorm());
  allowed_rad_ =
      kCorrected + static_cast<T>(kRatesLate_s) * fastest_rad_s_ + static_cast<T>(kRatesShare) * farthest_rad_;
  const T jumped2 = jumped_rad_.squaredNorm();
  if (jumped2 * allowed_rad_ * allowed_rad_ > residual_rad_ * residual_rad_ * kCorrected * kCorrected) {
    residual_rad_ = core::sqrt(jumped2);
    allowed_rad_ = kCorrected;
  }
  cusum_.add(residual_rad_, allowed_rad_, passed_s);
}

template class AttitudeRateConsistency<float>;
template class AttitudeRateConsistency<double>;

}  // namespace m100::est
