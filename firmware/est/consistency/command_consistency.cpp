// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/command_consistency.h"

#include "firmware/core/maths.h"

namespace m100::est {
namespace {

constexpr double kTrimMemory_s = 0.5, kMemory_s = 1.0, kSane_rad2 = 1e6;

}  // namespace

template <typename T>
void CommandConsistency<T>::update(const Estimate<T>& estimate, const Vector2& model_tilt_rad, bool ours, T step_s) {
  const Vector2 reported_rad(estimate.x.tilt_rad, estimate.y.tilt_rad);
  const T trim_share = step_s * static_cast<T>(1.0 / kTrimMemory_s);
  core::low_pass(mean_reported_rad_, reported_rad, trim_share);
  core::low_pass(mean_model_rad_, model_tilt_rad, trim_share);
  const Vector2 reported = reported_rad - mean_reported_rad_;
  const Vector2 apart = reported - (model_tilt_rad - mean_model_rad_);
  const T share = step_s * static_cast<T>(1.0 / kMemory_s);
  residual_rad2_ = ours ? residual_rad2_ + (apart.squaredNorm() - residual_rad2_) * share : T(0);
  reported_rad2_ = ours ? reported_rad2_ + (reported.squaredNorm() - reported_rad2_) * share : T(0);
  if (!(residual_rad2_ + reported_rad2_ < static_cast<T>(kSane_rad2))) {
    *this = {};  // a mean that is not finite would never raise an alarm
  }
  lasts_s_ = residual_rad2_ > allowed_rad2() ? core::clamp(lasts_s_ + step_s, T(0), T(1)) : T(0);
}

template class CommandConsistency<float>;
template class CommandConsistency<double>;

}  // namespace m100::est
