// SPDX-License-Identifier: BSD-3-Clause
// Computes the coefficients and scales of an axis' filter from its model; before the first tick.
#include "firmware/core/maths.h"
#include "firmware/est/filter/axis_filter.h"
#include "firmware/est/filter/units.h"

namespace m100::est {
namespace {

constexpr int exponent_above(double value) {
  int exponent = -20;
  while (exponent < 6 && power_of_two(exponent) < value) {
    ++exponent;
  }
  return exponent + 2;  // headroom
}

}  // namespace

template <typename S>
AxisFilter<S>::AxisFilter(const AxisModel& model) : AxisFilter(model, steady_scales<S>(model)) {}

template <typename S>
AxisFilter<S>::AxisFilter(const AxisModel& model, const Scales& scales) : scales_(scales) {
  const auto number = [](double value) { return core::Arithmetic<S>::template number<double>(value); };
  const auto ratio = [&](int from, int to) {  // scaled entry = entry * 2^(e_from - e_to)
    return power_of_two(scales_[static_cast<std::size_t>(from)] - scales_[static_cast<std::size_t>(to)]);
  };
  const model::AxisStep step = tick_of(model.attitude);
  const double o_r = step.o_r / kTimeUnit_s, ro = step.ro * kTimeUnit_s;
  const double r_m = (step.r_u + step.r_next) * kTimeUnit_s;
  const double tick = power_of_two(kTickExponent);
  const double gravity = model.tilt_sign * model.tilt_gain * model::kGravity_m_s2 / kAccelerationUnit_m_s2;
  const double drag = model.linear_drag_per_s * kTimeUnit_s;

  response_ = ResponseStep<S>::of(step);
  c_.gravity = number(gravity);
  c_.half_gravity = number(0.5 * gravity);
  c_.drag = number(drag);
  c_.square_drag = number(model.quadratic_drag_per_m);

  // d(acceleration)/d(tilt, rate, m) = g / cos^2(tilt) (1 + oo, o_r, o_u) / 2: the slope at the middle of the tick.
  c_.v_tilt = number(tick * gravity * 0.5 * (1.0 + step.oo) * ratio(kTilt, kV));
  c_.v_rate = number(tick * gravity * 0.5 * o_r * ratio(kRate, kV));
  c_.v_m = number(tick * gravity * 0.5 * step.o_u * ratio(kM, kV));
  c_.tick_drag = number(1.0 - tick * drag);
  c_.tick_square_drag = number(2.0 * tick * model.quadratic_drag_per_m);

  phi_[kP][kV] = number(tick * ratio(kV, kP));
  phi_[kP][kD] = number(0.5 * tick * tick * ratio(kD, kP));
  phi_[kV][kD] = number(tick * ratio(kD, kV));
  phi_[kTilt][kTilt] = number(step.oo);
  phi_[kTilt][kRate] = number(o_r * ratio(kRate, kTilt));
  phi_[kTilt][kM] = number(step.o_u * ratio(kM, kTilt));
  phi_[kRate][kTilt] = number(ro * ratio(kTilt, kRate));
  phi_[kRate][kRate] = number(step.rr);
  phi_[kRate][kM] = number(r_m * ratio(kM, kRate));

  const model::EstimatorNoise& noise = model.noise;
  const std::array<double, kStates> per_root_s{noise.position_process_m,
                                               noise.velocity_process_m_s / kVelocityUnit_m_s,
                                               noise.tilt_process_rad,
                                               noise.tilt_rate_process_rad_s / kRateUnit_rad_s,
                                               noise.disturbance_process_m_s2 / kAccelerationUnit_m_s2,
                                               noise.input_offset_process_rad};
  for (std::size_t i = 0; i < per_root_s.size(); ++i) {
    const double scale = power_of_two(-scales_[i]);
    q_[i] = number(per_root_s[i] * per_root_s[i] * kTick_s * scale * scale);
  }
  const auto variance = [&](double sigma, int measured) {
    const double scaled = sigma * power_of_two(-scales_[static_cast<std::size_t>(measured)]);
    return number(scaled * scaled);
  };
  c_.pose_variance = variance(noise.pose_position_sigma_m, kP);
  c_.tilt_variance = variance(noise.attitude_sigma_rad, kTilt);
  c_.rate_variance = variance(noise.rate_sigma_rad_s / kRateUnit_rad_s, kRate);
  c_.pose_rate = number(ratio(kV, kP));
  c_.pose_d = number(ratio(kD, kP));
  c_.tilt_rate = number(ratio(kRate, kTilt));
  start(S{});
}

template <typename S>
typename AxisFilter<S>::Scales steady_scales(const AxisModel& model) {
  using Filter = AxisFilter<S>;
  // Rough scales first: the limits of scaled variances must not bind while the filter settles.
  constexpr typename Filter::Scales kRough{-8, -5, -6, -2, -2, -5};
  Filter filter(model, kRough);
  const MeasurementAge<S> pose_age = MeasurementAge<S>::of(0.02);
  const MeasurementAge<S> attitude_age = MeasurementAge<S>::of(0.0);
  for (int tick = 0; tick < 500; ++tick) {
    filter.predict({});
    filter.fuse_attitude(S{}, S{}, attitude_age);
    filter.fuse_pose(filter.test_pose(S{}, pose_age, S{}, 0.F));
    filter.check();
  }
  typename Filter::Scales scales{};
  for (int i = 0; i < Filter::kStates; ++i) {
    const auto j = static_cast<std::size_t>(i);
    const double variance = core::Arithmetic<S>::template real<double>(filter.scaled_covariance(i, i));
    scales[j] = exponent_above(core::sqrt(variance) * power_of_two(kRough[j]));
  }
  return scales;
}

template AxisFilter<double>::Scales steady_scales<double>(const AxisModel&);
template AxisFilter<float>::Scales steady_scales<float>(const AxisModel&);
template AxisFilter<core::Fixed>::Scales steady_scales<core::Fixed>(const AxisModel&);
template AxisFilter<double>::AxisFilter(const AxisModel&);
template AxisFilter<double>::AxisFilter(const AxisModel&, const Scales&);
template AxisFilter<float>::AxisFilter(const AxisModel&);
template AxisFilter<float>::AxisFilter(const AxisModel&, const Scales&);
template AxisFilter<core::Fixed>::AxisFilter(const AxisModel&);
template AxisFilter<core::Fixed>::AxisFilter(const AxisModel&, const Scales&);

}  // namespace m100::est
