// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/command_consistency.h"

#include "firmware/est/filter/model_velocity.h"
#include "firmware/model/vehicle.h"

namespace m100::est {
namespace {

constexpr double kMemory_s = 1.0, kSaneSum = 1e6;

}  // namespace

template <typename T>
void CommandConsistency<T>::update(const Vector2& apart_m_s, const Tilted& tilted, bool poses_come, bool ours,
                                   T step_s) {
  constexpr T kPerTilt_m_s = static_cast<T>(model::kGravity_m_s2 * kMemory_s);
  const T fades = ours ? step_s * static_cast<T>(1.0 / kMemory_s) : T(1);
  const Vector2 unreported_m_s2 = tilted.commanded_m_s2 - tilted.reported_m_s2;
  unreported_m_s_ += unreported_m_s2 * step_s - unreported_m_s_ * fades;
  lag_m_s_ +=
      unreported_m_s2 * step_s - lag_m_s_ * (ours ? step_s * static_cast<T>(1.0 / ModelVelocity<T>::kLag_s) : T(1));
  commanded_m_s_ += core::sqrt(tilted.commanded_m_s2.squaredNorm()) * step_s - commanded_m_s_ * fades;
  const Vector2 without_lag_m_s = apart_m_s - lag_m_s_;
  mean_apart_m_s_ += (apart_m_s - mean_apart_m_s_) * fades;
  mean_without_lag_m_s_ += (without_lag_m_s - mean_without_lag_m_s_) * fades;
  const Vector2 contradiction_m_s = apart_m_s - mean_apart_m_s_;
  const T if_poses = unreported_m_s_.squaredNorm();
  const T if_unanswered = (without_lag_m_s - mean_without_lag_m_s_).squaredNorm();
  const T if_attitude = (contradiction_m_s - unreported_m_s_).squaredNorm();
  const T error_m_s = static_cast<T>(kModelError_rad) * kPerTilt_m_s + static_cast<T>(kGainError) * commanded_m_s_;
  const bool is_likeliest = poses_come && contradiction_m_s.squaredNorm() > T(4) * error_m_s * error_m_s &&
                            if_attitude < if_poses && if_attitude < if_unanswered;
  lasts_s_ = is_likeliest ? core::clamp(lasts_s_ + step_s, T(0), T(1)) : T(0);
  residual_rad_ = core::sqrt(if_poses) / kPerTilt_m_s;
  allowed_rad_ = error_m_s / kPerTilt_m_s;
  if (!(mean_apart_m_s_.squaredNorm() + mean_without_lag_m_s_.squaredNorm() + unreported_m_s_.squaredNorm() +
            commanded_m_s_ <
        static_cast<T>(kSaneSum))) {
    *this = {};  // a sum that is not finite would never raise an alarm
  }
}

template class CommandConsistency<float>;
template class CommandConsistency<double>;

}  // namespace m100::est
