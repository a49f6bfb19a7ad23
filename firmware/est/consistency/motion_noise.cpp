// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/motion_noise.h"

namespace m100::est {
namespace {

constexpr double kNoiseMemory_s = 3.0;
/// With a gain K per pose, white pose noise leaves in the estimated path of the height 1 / 2K times the noise of the
/// corrections. The level is half of that, because PathConsistency takes it twice.
constexpr double kPerGain = 0.25, kMinGain = 0.02;

}  // namespace

template <typename T>
void MotionNoise<T>::Differences::add(const Vector3& now, T weight, T vertical_weight, T share) {
  const Vector3 apart = now - before;
  before = now;
  level.horizontal += (T(0.25) * apart.template head<2>().squaredNorm() * weight - level.horizontal) * share;
  level.vertical += (T(0.5) * apart.z() * apart.z() * vertical_weight - level.vertical) * share;
}

template <typename T>
void MotionNoise<T>::update(const ImuSample<T>& imu, const SpecificForce<T>& force, const Estimate<T>& estimate,
                            bool pose_used, T step_s) {
  const T known_s = core::clamp(force.learned_s(), T(0.3), static_cast<T>(kNoiseMemory_s));
  force_age_s_ += step_s;
  if (imu.force_is_new) {
    const T reading_m_s2 = imu.force_b.cwiseAbs().maxCoeff() * force.scale_m_s2();
    vibration_.update(force.raw_m_s2(), reading_m_s2, force_age_s_, known_s);
    force_age_s_ = T(0);
  }
  const Vector3 position_m(estimate.x.position_m, estimate.y.position_m, estimate.height_m);
  since_correction_s_ = core::clamp(since_correction_s_ + step_s, T(0), T(1));
  if (pose_used) {
    const Vector3 flown_m_s(estimate.x.velocity_m_s, estimate.y.velocity_m_s, estimate.climb_m_s);
    const T per_gain = T(1) / core::clamp(estimate.height_gain, static_cast<T>(kMinGain), T(1));
    position_.add(position_m - position_w_m_ - flown_m_s * step_s, step_s / since_correction_s_,
                  static_cast<T>(kPerGain) * per_gain, core::clamp(since_correction_s_ / known_s, T(0), T(1)));
    climb_per_height_s_ = estimate.climb_gain_per_s * per_gain;
    since_correction_s_ = T(0);
  }
  position_w_m_ = position_m;
}

template class MotionNoise<float>;
template class MotionNoise<double>;

}  // namespace m100::est
