// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/answer_check.h"

namespace m100::est {
namespace {

constexpr double kTrimMemory_s = 0.5, kMemory_s = 1.0, kSane_rad2 = 1e6;

}  // namespace

template <typename T>
void AnswerCheck<T>::update(const Estimate<T>& estimate, const Vector2& asked_rad, bool ours, T step_s) {
  const Vector2 told_rad(estimate.x.tilt_rad, estimate.y.tilt_rad);
  const T trim_share = step_s * static_cast<T>(1.0 / kTrimMemory_s);
  mean_told_rad_ += (told_rad - mean_told_rad_) * trim_share;
  mean_asked_rad_ += (asked_rad - mean_asked_rad_) * trim_share;
  const Vector2 told = told_rad - mean_told_rad_;
  const Vector2 apart = told - (asked_rad - mean_asked_rad_);
  const T share = step_s * static_cast<T>(1.0 / kMemory_s);
  apart_rad2_ = ours ? apart_rad2_ + (apart.squaredNorm() - apart_rad2_) * share : T(0);
  told_rad2_ = ours ? told_rad2_ + (told.squaredNorm() - told_rad2_) * share : T(0);
  if (!(apart_rad2_ + told_rad2_ < static_cast<T>(kSane_rad2))) {
    *this = {};  // a mean that is not finite would never raise an alarm
  }
  lasts_s_ = apart_rad2_ > allowed_rad2() ? core::clamp(lasts_s_ + step_s, T(0), T(1)) : T(0);
}

template class AnswerCheck<float>;
template class AnswerCheck<double>;

}  // namespace m100::est
