// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/sysid/axis_model.h"

#include <bit>
#include <cstddef>
#include <cstdint>

#include "firmware/core/maths.h"
#include "firmware/model/paper.h"

namespace m100::sysid {
namespace {

using Matrix2 = std::array<double, 4>;  // row-major

Matrix2 times(const Matrix2& p, const Matrix2& q) {
  return {p[0] * q[0] + p[1] * q[2], p[0] * q[1] + p[1] * q[3], p[2] * q[0] + p[3] * q[2], p[2] * q[1] + p[3] * q[3]};
}

// Scaling by 2^-4 keeps the argument below 0.7 for everything the constructor allows; 12 terms then give full accuracy.
Matrix2 exponential(const Matrix2& matrix) {
  Matrix2 small{};
  for (std::size_t i = 0; i < 4; ++i) {
    small[i] = matrix[i] / 16.0;
  }
  Matrix2 sum{1.0, 0.0, 0.0, 1.0};
  for (int term = 12; term > 0; --term) {
    sum = times(small, sum);
    for (double& entry : sum) {
      entry /= term;
    }
    sum[0] += 1.0;
    sum[3] += 1.0;
  }
  for (int squaring = 0; squaring < 4; ++squaring) {
    sum = times(sum, sum);
  }
  return sum;
}

// ln x = e ln 2 + 2 atanh((m - 1) / (m + 1)), m in [sqrt(1/2), sqrt(2)).
double logarithm(double x) {
  std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
  int exponent = static_cast<int>(bits >> 52U) - 1023;
  bits = (bits & 0x000FFFFFFFFFFFFFULL) | 0x3FF0000000000000ULL;
  double mantissa = std::bit_cast<double>(bits);
  if (mantissa > 1.4142135623730951) {
    mantissa *= 0.5;
    ++exponent;
  }
  const double z = (mantissa - 1.0) / (mantissa + 1.0);
  const double z2 = z * z;
  double sum = 0.0;
  for (int k = 19; k >= 1; k -= 2) {
    sum = sum * z2 + 1.0 / k;
  }
  return exponent * 0.69314718055994530942 + 2.0 * z * sum;
}

}  // namespace

template <typename Real>
Real power(Real x, Real exponent) {
  if (!(x > Real(1e-12))) {
    return Real(0);
  }
  return static_cast<Real>(core::exp(static_cast<double>(exponent) * logarithm(static_cast<double>(x))));
}

AxisModel<double> to_axis_model(const model::AttitudeAxis& axis) {
  AxisModel<double> out;
  out.gain = axis.scale_rad_per_count;
  out.time_constant_s = axis.time_constant_s;
  out.natural_frequency_rad_s = axis.natural_frequency_rad_s;
  out.damping_ratio = axis.damping_ratio;
  out.delay_s = axis.transport_delay_s;
  out.lead_zero_s = axis.lead_zero_s;
  out.dead_zone_counts = axis.dead_zone_counts;
  out.dead_zone_shape = axis.dead_zone_shape;
  out.trim_counts = axis.trim_counts;
  out.stick_exponent = axis.stick_exponent;
  out.backlash_counts = axis.backlash_counts;
  out.saturation = axis.saturation_rad;
  out.rate_limit_per_s = axis.rate_limit_rad_s;
  out.gain_asymmetry = axis.gain_asymmetry;
  out.gain_drift_per_s = axis.gain_drift_per_minute / 60.0;
  out.cross_axis = axis.cross_axis;
  return out;
}

AxisModel<double> to_axis_model(const model::RateAxis& axis) {
  AxisModel<double> out;
  out.gain = axis.scale_per_count;
  out.time_constant_s = axis.time_constant_s;
  out.natural_frequency_rad_s = axis.natural_frequency_rad_s;
  out.damping_ratio = axis.damping_ratio;
  out.delay_s = axis.transport_delay_s;
  out.dead_zone_counts = axis.dead_zone_counts;
  out.dead_zone_shape = axis.dead_zone_shape;
  out.trim_counts = axis.trim_counts;
  out.stick_exponent = axis.stick_exponent;
  out.saturation = axis.limit;
  out.rate_limit_per_s = axis.rate_limit;
  out.gain_asymmetry = axis.gain_asymmetry;
  out.lead_zero_s = axis.lead_zero_s;
  out.backlash_counts = axis.backlash_counts;
  out.gain_drift_per_s = axis.gain_drift_per_minute / 60.0;
  return out;
}

template <typename Real>
StaticLaw<Real>::StaticLaw(const AxisModel<Real>& model, Real sample_period_s)
    : model_(model),
      slew_per_sample_(model.command_slew_per_s * sample_period_s),
      positive_gain_(model.gain * Real(2) * model.gain_asymmetry / (Real(1) + model.gain_asymmetry)),
      negative_gain_(model.gain * Real(2) / (Real(1) + model.gain_asymmetry)) {}

template <typename Real>
Real StaticLaw<Real>::dead_zone_and_curve(Real counts) const {
  Real size = counts < Real(0) ? -counts : counts;
  if (model_.dead_zone_counts > Real(0)) {
    if (size <= model_.dead_zone_counts) {
      return Real(0);
    }
    if (model_.dead_zone_shape == model::DeadZoneShape::kContinuous) {
      size -= model_.dead_zone_counts;
    }
  }
  if (model_.stick_exponent != Real(1)) {
    constexpr Real kTravel = static_cast<Real>(model::paper::kTravel_vrc);
    size = kTravel * power(size / kTravel, model_.stick_exponent);
  }
  return counts < Real(0) ? -size : size;
}

template <typename Real>
Real StaticLaw<Real>::command(Real stick_counts, Real other_counts, Real t_s) {
  Real stick = stick_counts;
  if (model_.backlash_counts > Real(0)) {
    play_counts_ =
        started_ ? core::clamp(play_counts_, stick - model_.backlash_counts, stick + model_.backlash_counts) : stick;
    stick = play_counts_;
  }
  stick -= model_.trim_counts;
  Real command = dead_zone_and_curve(stick);
  command *= command < Real(0) ? negative_gain_ : positive_gain_;
  command += model_.gain * model_.cross_axis * other_counts;
  command *= Real(1) + model_.gain_drift_per_s * t_s;
  if (model_.tilt_limit > Real(0)) {
    const Real other =
        (model_.other_gain > Real(0) ? model_.other_gain : model_.gain) * dead_zone_and_curve(other_counts);
    const Real size = core::sqrt(command * command + other * other);
    if (size > model_.tilt_limit) {
      command *= model_.tilt_limit / size;
    }
  }
  if (model_.saturation > Real(0)) {
    command = core::clamp(command, -model_.saturation, model_.saturation);
  }
  if (slew_per_sample_ > Real(0)) {
    slewed_ = started_ ? slewed_ + core::clamp(command - slewed_, -slew_per_sample_, slew_per_sample_) : command;
    command = slewed_;
  }
  started_ = true;
  return command;
}

template <typename Real>
AxisDynamics<Real>::AxisDynamics(const AxisModel<Real>& model, Real sample_period_s)
    : first_order_(model.time_constant_s > Real(0)),
      sample_period_s_(sample_period_s),
      limit_per_s_(model.rate_limit_per_s) {
  const double period = static_cast<double>(sample_period_s);
  if (first_order_) {
    const double ratio = core::clamp(period / static_cast<double>(model.time_constant_s), 0.0, 80.0);
    a11_ = static_cast<Real>(core::exp(-ratio));
    return;
  }
  const double w = static_cast<double>(model.natural_frequency_rad_s);
  const double z = static_cast<double>(model.damping_ratio);
  const Matrix2 phi = exponential({0.0, period, -w * w * period, -2.0 * z * w * period});
  a11_ = static_cast<Real>(phi[0]);
  a12_ = static_cast<Real>(phi[1]);
  a21_ = static_cast<Real>(phi[2]);
  a22_ = static_cast<Real>(phi[3]);
}

template <typename Real>
void AxisDynamics<Real>::start(Real value, Real rate_per_s) {
  value_ = value;
  rate_per_s_ = limit_per_s_ > Real(0) ? core::clamp(rate_per_s, -limit_per_s_, limit_per_s_) : rate_per_s;
}

template <typename Real>
Real AxisDynamics<Real>::limited(Real before, Real after) const {
  const Real most = limit_per_s_ * sample_period_s_;
  return before + core::clamp(after - before, -most, most);
}

template <typename Real>
void AxisDynamics<Real>::limit_rate(Real before) {
  rate_per_s_ = core::clamp(rate_per_s_, -limit_per_s_, limit_per_s_);
  value_ = limited(before, value_);
}

template float power<float>(float, float);
template double power<double>(double, double);
template class StaticLaw<float>;
template class StaticLaw<double>;
template class AxisDynamics<float>;
template class AxisDynamics<double>;

}  // namespace m100::sysid
