// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/filter/axis_filter.h"

#include <array>

#include "firmware/est/estimate.h"

namespace m100::est {
namespace {

/// Largest magnitude of each state. Up to the limit of the tilt, tangent_of() is exact to 4e-9.
template <typename S>
constexpr typename Kalman<S, 6>::Limits kLimits{S(100.0), S(25.0), S(0.7), S(10.0), S(8.0), S(0.3)};
/// Sigmas at the start: what a healthy aircraft may have then. Some thirty times those in steady flight.
constexpr std::array kInitialSigma{0.03, 0.4, 0.06, 0.8, 2.5, 0.06};

/// tan(t) = t (1 - t^2/9 + t^4/945) / (1 - 4 t^2/9 + t^4/63), the [5/4] Pade approximant.
template <typename S>
S tangent_of(S t) {
  const S t2 = t * t;
  const S t4 = t2 * t2;
  const S bottom = S(1) - t2 * S(4.0 / 9.0) + t4 * S(1.0 / 63.0);
  return t * (S(1) - t2 * S(1.0 / 9.0) + t4 * S(1.0 / 945.0)) / bottom;
}

/// H v of a position of a time ago.
template <typename S>
auto position_of(S age_s) {
  using Filter = AxisFilter<S>;
  return [age_s, half_square = S(0.5) * age_s * age_s](const auto& v) -> S {
    return v(Filter::kP) - v(Filter::kV) * age_s + v(Filter::kD) * half_square;
  };
}

}  // namespace

template <typename S>
[[gnu::cold]] AxisFilter<S>::AxisFilter(const AxisModel& model)
    : response_(ResponseStep<S>::of(tick_of(model.attitude))),
      rate_per_offset_{response_.r_u + response_.r_next},
      gravity_{S(model.tilt_sign * model.tilt_gain * model::kGravity_m_s2)},
      linear_drag_{S(model.linear_drag_per_s)},
      quadratic_drag_{S(model.quadratic_drag_per_m)} {
  const model::EstimatorNoise& noise = model.noise;
  const core::Vector<double, kStates> process{noise.position_process_m,       noise.velocity_process_m_s,
                                              noise.tilt_process_rad,         noise.tilt_rate_process_rad_s,
                                              noise.disturbance_process_m_s2, noise.input_offset_process_rad};
  q_ = (process.cwiseAbs2() * kTick_s).template cast<S>();
  const auto square = [](double sigma) { return S(sigma * sigma); };
  pose_variance_ = square(noise.pose_position_sigma_m);
  tilt_variance_ = square(noise.attitude_sigma_rad);
  rate_variance_ = square(noise.rate_sigma_rad_s);
  start(S(0));
}

template <typename S>
[[gnu::cold]] void AxisFilter<S>::start(S tilt_rad) {
  filter_.start(core::Vector<double, kStates>(kInitialSigma.data()));
  filter_.x(kTilt) = tilt_rad;
  filter_.clamp(kLimits<S>);
  history_ = {};
  angular_acceleration_ = S(0);
}

template <typename S>
S AxisFilter<S>::drag(S velocity_m_s) const {
  const S speed = velocity_m_s < S(0) ? -velocity_m_s : velocity_m_s;
  return (linear_drag_ + quadratic_drag_ * speed) * velocity_m_s;
}

template <typename S>
void AxisFilter<S>::predict(const ActingInputs<S>& command_rad) {
  constexpr double kHalf_s = 0.5 * kTick_s;
  auto& x = filter_.x;
  const S speed = x(kV), tangent = tangent_of(x(kTilt));
  const S slope = S(0.5) * gravity_ * (S(1) + tangent * tangent);  // g / (2 cos^2)
  const auto next = response_.advance({.output = x(kTilt), .rate = x(kRate)}, command_rad, x(kM));
  model_response_ = response_.advance(model_response_, command_rad, S(0));
  angular_acceleration_ = (next.rate - x(kRate)) * S(1.0 / kTick_s);
  const S acceleration = gravity_ * tangent + slope * (next.output - x(kTilt)) - drag(speed);
  history_.add(acceleration);

  const S drag_slope = linear_drag_ + S(2) * quadratic_drag_ * (speed < S(0) ? -speed : speed);
  filter_.predict(
      [&](const auto& v) {  // F v
        const S tilt = response_.oo * v(kTilt) + response_.o_r * v(kRate) + response_.o_u * v(kM);
        const S rate = response_.ro * v(kTilt) + response_.rr * v(kRate) + rate_per_offset_ * v(kM);
        const S faster = v(kV) + (slope * (v(kTilt) + tilt) - drag_slope * v(kV) + v(kD)) * S(kTick_s);
        return core::Vector<S, kStates>{v(kP) + (v(kV) + faster) * S(kHalf_s), faster, tilt, rate, v(kD), v(kM)};
      },
      q_);

  const S faster = speed + (acceleration + x(kD)) * S(kTick_s);
  x(kP) += (speed + faster) * S(kHalf_s);
  x(kV) = faster;
  x(kTilt) = next.output;
  x(kRate) = next.rate;
  filter_.clamp(kLimits<S>);
}

template <typename S>
void AxisFilter<S>::fuse_specific_force(S disturbance_m_s2, DisturbanceUse use) {
  if (use == DisturbanceUse::kHeld) {
    return;
  }
  const S now = disturbance_m_s2 + drag(filter_.x(kV));
  if (use == DisturbanceUse::kTracked) {
    const S moved = filter_.x(kD) + now - stored_disturbance_;
    filter_.x(kD) = core::clamp(moved, now - S(kForceOffset_m_s2), now + S(kForceOffset_m_s2));
    filter_.clamp(kLimits<S>);
  }
  stored_disturbance_ = now;
}

template <typename S>
FusionResult AxisFilter<S>::fuse_attitude(S tilt_rad, S rate_rad_s, S age_s) {
  const auto& x = filter_.x;
  // Expected at the age a: tilt - a rate + a^2/2 rate', and rate - a rate'.
  const S spun = age_s * angular_acceleration_;
  const S tilt_error = tilt_rad - x(kTilt) + age_s * (x(kRate) - spun * S(0.5));
  const auto rate_error = [&] { return rate_rad_s - x(kRate) + spun; };
  const auto inside = [](S error, double gate) { return error <= S(gate) && error >= S(-gate); };
  constexpr double kTiltGate_rad = 0.35, kRateGate_rad_s = 5.0;
  if (!inside(tilt_error, kTiltGate_rad) || !inside(rate_error(), kRateGate_rad_s)) {
    return FusionResult::kRefused;
  }
  filter_.correct([=](const auto& v) -> S { return v(kTilt) - v(kRate) * age_s; }, tilt_error, tilt_variance_);
  // The rate's innovation, from the state after the correction by the tilt.
  filter_.correct([](const auto& v) -> S { return v(kRate); }, rate_error(), rate_variance_);
  filter_.clamp(kLimits<S>);
  return FusionResult::kUsed;
}

template <typename S>
PoseInnovation<S> AxisFilter<S>::test_pose(S position_m, S age_s, S unseen_m, S sender_variance_m2) const {
  const S noise_m2 = sender_variance_m2 > pose_variance_ ? sender_variance_m2 : pose_variance_;
  return est::test_pose(filter_, position_of(age_s), position_m, age_s, history_.displacement(age_s), noise_m2,
                        unseen_m);
}

template <typename S>
void AxisFilter<S>::fuse_pose(const PoseInnovation<S>& test) {
  filter_.correct_joseph(position_of(test.age_s), test.innovation_m, test.noise_m2);
  filter_.clamp(kLimits<S>);
}

template <typename S>
[[gnu::cold]] void AxisFilter<S>::reset_position(S position_m, S velocity_m_s, S age_s,
                                                 const MotionVariance& variance) {
  auto& x = filter_.x;
  x(kV) = velocity_m_s;
  x(kP) = position_m + age_s * (x(kV) - age_s * x(kD) * S(0.5)) - history_.displacement(age_s);
  filter_.decouple(kP, variance.position_m2, kInitialSigma[kP], kLimits<S>[kP]);
  filter_.decouple(kV, variance.velocity_m2_s2, kInitialSigma[kV], kLimits<S>[kV]);
  filter_.clamp(kLimits<S>);
}

template <typename S>
bool AxisFilter<S>::is_sane() const {
  return filter_.is_valid();
}

template class AxisFilter<double>;
template class AxisFilter<float>;
template class AxisFilter<core::Fixed>;

}  // namespace m100::est
