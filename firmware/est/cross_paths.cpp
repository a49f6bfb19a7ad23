// SPDX-License-Identifier: BSD-3-Clause
// Compares the paths of poses and specific force (MotionCheck), and measures the noise of both.
#include "firmware/core/frames.h"
#include "firmware/core/maths.h"
#include "firmware/est/cross_check.h"

namespace m100::est {
namespace {

/// Longer without a used pose is a gap: the observer's position is then its own prediction.
constexpr double kUsedLately_s = 0.15;
constexpr double kMostUnsure_m = 0.5;
/// The height filter reports no variance. A jolt of 1 m/s makes at most 0.23 / a of a path, 0.15 m of the slower one,
/// and lasts twice as long as the memory of the uncertainty; the force's own noise in a message is no jolt.
constexpr double kUnsureHeight_m = 0.0005, kJolt_s = 0.3, kNoJolt_m_s = 0.01;
/// When no pose comes for kPoseUsed, the observer's motion is its own prediction. Once poses come again they correct it
/// within this time, and the correction is no motion; refused poses are no such gap. The force bridges a path for at
/// most a second: an offset of 0.05 m/s^2 then makes 0.05 / 2 = 2.5 cm, the uncertainty of a new start.
constexpr double kMended_s = 0.3;
constexpr core::Duration kBridged = std::chrono::seconds(1);
constexpr double kNoiseMemory_s = 3.0;
constexpr double kLeansMean_s = 1.0;  // the high-pass of a path forgets a longer lean

}  // namespace

/// @returns whether the observer's velocity is its own prediction, or is being corrected by the first poses after a gap
template <typename T>
bool CrossCheck<T>::mends(const Estimate<T>& estimate, T step_s) {
  const bool unseen = estimate.pose_age > kPoseUsed && estimate.refused_poses == 0;
  mends_for_s_ = unseen ? static_cast<T>(kMended_s) : mends_for_s_ > step_s ? mends_for_s_ - step_s : T(0);
  if (unseen && estimate.pose_age > kBridged) {
    restart_paths();
  }
  return mends_for_s_ > T(0);
}

/// Starts once the offset of the force has been learned for a second. It uses the same force as kForce and is switched
/// off with it. The two paths take turns, which halves the cost.
template <typename T>
void CrossCheck<T>::follow(const Felt<T>& felt, const Estimate<T>& estimate, const core::Turn<T>& yaw, T step_s) {
  const bool used = estimate.refused_poses == 0 && core::seconds<T>(estimate.pose_age) < last_age_s_ + T(0.5) * step_s;
  last_age_s_ = core::seconds<T>(estimate.pose_age);
  note_noise(felt, estimate, used, step_s);
  unused_s_ = used ? T(0) : core::clamp(unused_s_ + step_s, T(0), T(1));
  if ((off_ & (set_of(Check::kMotion) | set_of(Check::kForce))) != 0 || force_seen_s_ < static_cast<T>(kBegins_s)) {
    restart_paths();
    return;
  }
  const bool sees = unused_s_ < static_cast<T>(kUsedLately_s);
  const Vector2 force_w_m_s2 = core::rotate<T>(force_h_m_s2_ + lacks_h_m_s2(), yaw);
  const T rises = rises_m_s2();
  upwards_ = !upwards_;
  if (upwards_) {
    follow_upwards(estimate, T(0.5) * (rises + rise_before_m_s2_), sees, T(2) * step_s);
  } else {
    follow_sideways(estimate, (force_w_m_s2 + force_before_w_m_s2_) * T(0.5), sees, T(2) * step_s);
  }
  force_before_w_m_s2_ = force_w_m_s2;
  rise_before_m_s2_ = rises;
  const bool contradicts = paths_evidence() >= T(1);
  if (contradicts && report_.check == Check::kNone) {
    const bool upwards = motion_.evidence() < climbs_.evidence();
    report_ = {.check = Check::kMotion,
               .measured = upwards ? climbs_.apart_m() : motion_.apart_m(),
               .allowed = upwards ? climbs_.allowed_m() : motion_.allowed_m()};
  } else if (!contradicts && report_.check == Check::kMotion) {
    report_ = {};
  }
}

template <typename T>
void CrossCheck<T>::Noise::add(const core::Vector<T, 3>& now, T weight, T share) {
  const core::Vector<T, 3> apart = now - before;
  before = now;
  level += (T(0.25) * apart.template head<2>().squaredNorm() * weight - level) * share;
  up += (T(0.5) * apart.z() * apart.z() * weight - up) * share;
}

/// Measures the noise of the force and of the poses: noise above the assumed values widens the bounds, noise below them
/// changes nothing. Per tick, at any rate of the poses.
template <typename T>
void CrossCheck<T>::note_noise(const Felt<T>& felt, const Estimate<T>& estimate, bool used, T step_s) {
  const T known_s = core::clamp(force_seen_s_, T(0.3), static_cast<T>(kNoiseMemory_s));
  force_age_s_ += step_s;
  if (felt.force_is_new) {
    force_noise_.add({force_h_m_s2_.x(), force_h_m_s2_.y(), lifted_m_s2_}, force_age_s_,
                     core::clamp(force_age_s_ / known_s, T(0), T(1)));
    force_age_s_ = T(0);
  }
  const core::Vector<T, 3> place_m(estimate.x.position_m, estimate.y.position_m, estimate.height_m);
  pushed_s_ = core::clamp(pushed_s_ + step_s, T(0), T(1));
  if (used) {
    const core::Vector<T, 3> flown_m_s(estimate.x.velocity_m_s, estimate.y.velocity_m_s, estimate.climb_m_s);
    push_noise_.add(place_m - place_w_m_ - flown_m_s * step_s, step_s / pushed_s_,
                    core::clamp(pushed_s_ / known_s, T(0), T(1)));
    pushed_s_ = T(0);
  }
  place_w_m_ = place_m;
}

/// A blow between two messages of the force changes the climb speed and is missing from the force; the autopilot's own
/// climb speed shows it.
template <typename T>
void CrossCheck<T>::note_jolt(const Felt<T>& felt, T step_s) {
  felt_gain_m_s_ += rises_m_s2() * step_s;
  if (felt.climb_is_new) {
    const T unfelt_m_s = felt.climb_m_s - felt_climb_m_s_ - felt_gain_m_s_;
    const T jolt_m_s = (unfelt_m_s < T(0) ? -unfelt_m_s : unfelt_m_s) - static_cast<T>(kNoJolt_m_s);
    jolt_m_s_ = jolt_m_s > jolt_m_s_ ? jolt_m_s : jolt_m_s_;
    felt_climb_m_s_ = felt.climb_m_s;
    felt_gain_m_s_ = T(0);
  }
}

template <typename T>
void CrossCheck<T>::follow_sideways(const Estimate<T>& estimate, const Vector2& force_w_m_s2, bool sees, T step_s) {
  motion_.update({.force_m_s2 = force_w_m_s2,
                  .place_m = Vector2(estimate.x.position_m, estimate.y.position_m),
                  .speed_m_s = velocity_w_m_s_,
                  // Without the corrections by poses (LagWatch): a lie would excuse itself by its own effect.
                  .unsure_m = core::sqrt(core::clamp(estimate.x.filter_variance_m2, estimate.y.filter_variance_m2,
                                                     static_cast<T>(kMostUnsure_m * kMostUnsure_m))),
                  .place_noise_m2 = push_noise_.level,
                  .force_noise_m2_s3 = force_noise_.level},
                 sees, step_s);
}

/// A hover moves more vertically than horizontally (the climb wanders by 5 cm/s in the measured logs), so a body that
/// stands still shows here first.
template <typename T>
void CrossCheck<T>::follow_upwards(const Estimate<T>& estimate, T rises_m_s2, bool sees, T step_s) {
  using Vector1 = core::Vector<T, 1>;
  // An aircraft that tilts against a gust stands still and turns the offsets of x and y upward.
  const Vector2 leans_h_m_s2 = tilted_h_m_s2_ - leans_h_m_s2_;
  leans_h_m_s2_ += leans_h_m_s2 * (step_s * static_cast<T>(1.0 / kLeansMean_s));
  climbs_.update({.force_m_s2 = Vector1(rises_m_s2),
                  .place_m = Vector1(estimate.height_m),
                  .speed_m_s = Vector1(estimate.climb_m_s),
                  .unsure_m = static_cast<T>(kUnsureHeight_m) + static_cast<T>(kJolt_s) * jolt_m_s_,
                  .place_noise_m2 = push_noise_.up,
                  .force_noise_m2_s3 = force_noise_.up,
                  .leans_m2_s4 = leans_h_m_s2.squaredNorm()},
                 sees, step_s);
  jolt_m_s_ = T(0);
}

template <typename T>
T CrossCheck<T>::paths_evidence() const {
  return motion_.evidence() < climbs_.evidence() ? climbs_.evidence() : motion_.evidence();
}

#define M100_PATHS_OF(T)                                                                            \
  template void CrossCheck<T>::follow(const Felt<T>&, const Estimate<T>&, const core::Turn<T>&, T); \
  template void CrossCheck<T>::follow_upwards(const Estimate<T>&, T, bool, T);                      \
  template void CrossCheck<T>::follow_sideways(const Estimate<T>&, const Vector2&, bool, T);        \
  template void CrossCheck<T>::note_jolt(const Felt<T>&, T);                                        \
  template void CrossCheck<T>::note_noise(const Felt<T>&, const Estimate<T>&, bool, T);             \
  template void CrossCheck<T>::Noise::add(const core::Vector<T, 3>&, T, T);                         \
  template bool CrossCheck<T>::mends(const Estimate<T>&, T);                                        \
  template T CrossCheck<T>::paths_evidence() const;
M100_PATHS_OF(float)
M100_PATHS_OF(double)
#undef M100_PATHS_OF

}  // namespace m100::est
