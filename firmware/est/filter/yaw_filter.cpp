// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/filter/yaw_filter.h"

#include <array>

#include "firmware/est/filter/response_step.h"

namespace m100::est {
namespace {

constexpr std::array kProcess{3e-3, 1e-3};  // rad and rad/s, per sqrt(s)
constexpr std::array kInitialSigma{0.03, 0.025};
template <typename S>
constexpr typename Kalman<S, 2>::Limits kLimits{S(3.15), S(0.2)};
constexpr double kRateLimit_rad_s = 10.0;

/// The angle, which is less than one turn outside, in (-pi, pi].
template <typename S>
S wrapped(S angle_rad) {
  const S pi = S(core::kPi), turn = S(2.0 * core::kPi);
  return angle_rad > pi ? angle_rad - turn : angle_rad > S(-core::kPi) ? angle_rad : angle_rad + turn;
}

}  // namespace

template <typename S>
YawFilter<S>::YawFilter(double yaw_sigma_rad) : variance_{S(yaw_sigma_rad * yaw_sigma_rad)} {
  start(S(0));
}

template <typename S>
void YawFilter<S>::start(S yaw_rad) {
  filter_.start(core::Vector<double, 2>(kInitialSigma.data()));
  filter_.x(kYaw) = wrapped(yaw_rad);
  rate_ = S(0);
}

template <typename S>
void YawFilter<S>::predict(S yaw_rate_rad_s) {
  const core::Vector<S, 2> q{S(kProcess[kYaw] * kProcess[kYaw] * kTick_s),
                             S(kProcess[kBias] * kProcess[kBias] * kTick_s)};
  rate_ = core::clamp(yaw_rate_rad_s, S(-kRateLimit_rad_s), S(kRateLimit_rad_s)) - filter_.x(kBias);
  filter_.x(kYaw) = wrapped(filter_.x(kYaw) + rate_ * S(kTick_s));
  filter_.predict([](const auto& v) { return core::Vector<S, 2>{v(kYaw) - v(kBias) * S(kTick_s), v(kBias)}; }, q);
}

template <typename S>
S YawFilter<S>::innovation(S yaw_rad, S age_s) const {
  return wrapped(wrapped(yaw_rad - filter_.x(kYaw)) + age_s * rate_);
}

template <typename S>
void YawFilter<S>::correct(S innovation_rad, S age_s) {
  filter_.correct([age_s](const auto& v) -> S { return v(kYaw) + v(kBias) * age_s; }, innovation_rad, variance_);
  filter_.x(kYaw) = wrapped(filter_.x(kYaw));
  filter_.clamp(kLimits<S>);
}

template <typename S>
void YawFilter<S>::reset_yaw(S yaw_rad) {
  filter_.x(kYaw) = wrapped(yaw_rad);
  filter_.decouple(kYaw, 0.0, kInitialSigma[kYaw], kLimits<S>[kYaw]);
}

template <typename S>
bool YawFilter<S>::is_sane() const {
  return filter_.is_valid() && rate_ == rate_;
}

template class YawFilter<double>;
template class YawFilter<float>;
template class YawFilter<core::Fixed>;

}  // namespace m100::est
