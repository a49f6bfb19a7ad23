// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/filter/yaw_filter.h"

#include <array>
#include <string_view>

#include "firmware/core/maths.h"
#include "firmware/est/filter/filter_math.h"
#include "firmware/est/filter/units.h"

namespace m100::est {
namespace {

constexpr double kYawScale = 1.0 / 256.0;   // 2^-8 rad
constexpr double kBiasScale = 1.0 / 512.0;  // 2^-9 rad per unit
constexpr int kBiasShift = -1;
constexpr double kYawProcess_rad = 3e-3;     // per sqrt(s)
constexpr double kBiasProcess_rad_s = 1e-3;  // per sqrt(s)
constexpr double kBiasLimit = 0.2 * kTimeUnit_s;
constexpr double kRateLimit = 10.0 * kTimeUnit_s;
constexpr double kInitialVariance = 64.0;

struct Transition {
  static constexpr std::array<std::string_view, 2> kRows{"1x", "01"};
};
struct MeasuresYaw {
  static constexpr std::string_view kRow = "1x";
};

}  // namespace

template <typename S>
YawFilter<S>::YawFilter(double yaw_sigma_rad) {
  const auto number = [](double value) { return core::Arithmetic<S>::template number<double>(value); };
  phi_[0][1] = number(-kTick_s / kTimeUnit_s * kBiasScale / kYawScale);
  const double yaw = kYawProcess_rad / kYawScale;
  const double bias = kBiasProcess_rad_s * kTimeUnit_s / kBiasScale;
  q_ = {number(yaw * yaw * kTick_s), number(bias * bias * kTick_s)};
  const double sigma = yaw_sigma_rad / kYawScale;
  variance_ = number(sigma * sigma);
  start(S{});
}

template <typename S>
void YawFilter<S>::start(S yaw) {
  yaw_ = wrapped(yaw);
  bias_ = S{};
  rate_ = S{};
  covariance_.set_diagonal({kInitialVariance, kInitialVariance});
}

template <typename S>
S YawFilter<S>::wrapped(S angle) {
  auto& a = covariance_.arithmetic();
  const S pi = core::Arithmetic<S>::template number<double>(core::kPi);
  const S turn = core::Arithmetic<S>::template number<double>(2.0 * core::kPi);
  const S minus_pi = core::Arithmetic<S>::template number<double>(-core::kPi);
  if (angle > pi) {
    return a.narrow(a.widen(angle) - a.widen(turn));
  }
  return angle > minus_pi ? angle : a.narrow(a.widen(angle) + a.widen(turn));
}

template <typename S>
void YawFilter<S>::predict(S yaw_rate) {
  auto& a = covariance_.arithmetic();
  rate_ = a.narrow(a.widen(limited(yaw_rate, kRateLimit)) - a.widen(bias_));
  yaw_ = wrapped(a.narrow(a.widen(yaw_) + a.scaled(a.widen(rate_), kTickExponent)));
  covariance_.template predict<Transition>(phi_, q_);
}

template <typename S>
S YawFilter<S>::innovation(S yaw, const MeasurementAge<S>& age) {
  auto& a = covariance_.arithmetic();
  const S seen = wrapped(a.narrow(a.widen(yaw) - a.widen(yaw_)));
  return wrapped(a.narrow(a.widen(seen) + a.product(age.units, rate_)));
}

template <typename S>
void YawFilter<S>::correct(S innovation, const MeasurementAge<S>& age) {
  auto& a = covariance_.arithmetic();
  typename Covariance::Column h{};
  h[1] = a.narrow(a.scaled(a.widen(age.units), kBiasShift));  // the bias has acted on the prediction during the age
  const auto gain = covariance_.update(covariance_.template project<MeasuresYaw>(h, variance_));
  yaw_ = wrapped(a.narrow(a.widen(yaw_) + a.product(gain[0], innovation)));
  const auto correction = a.scaled(a.product(gain[1], innovation), kBiasShift);
  bias_ = limited(a.narrow(a.widen(bias_) + correction), kBiasLimit);
  covariance_.check();
}

template <typename S>
void YawFilter<S>::reset_position(S yaw) {
  yaw_ = wrapped(yaw);
  covariance_.decouple(0, core::Arithmetic<S>::template number<double>(kInitialVariance));
}

template <typename S>
bool YawFilter<S>::is_sane() const {
  const S pi = core::Arithmetic<S>::template number<double>(3.15);
  const S minus_pi = core::Arithmetic<S>::template number<double>(-3.15);
  return yaw_ <= pi && yaw_ >= minus_pi && bias_ == bias_ && rate_ == rate_ && covariance_(0, 0) > S{} &&
         covariance_(1, 1) > S{};
}

template class YawFilter<double>;
template class YawFilter<float>;
template class YawFilter<core::Fixed>;

}  // namespace m100::est
