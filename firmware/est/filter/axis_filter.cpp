// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/filter/axis_filter.h"

#include <string_view>

#include "firmware/core/maths.h"
#include "firmware/est/estimate.h"
#include "firmware/est/filter/units.h"

namespace m100::est {
namespace {

constexpr double kDisturbanceLimit = 8.0 * kTimeUnit_s * kTimeUnit_s;
// Largest magnitude of each state, in filter units. Up to the limit of the tilt, tangent_of() is exact to 4e-9.
constexpr std::array kLimits{100.0, 25.0 * kTimeUnit_s, 0.7, 10.0 * kTimeUnit_s, kDisturbanceLimit, 0.3};
constexpr double kInitialSigmas = 8.0;  // in units of the scale: scaled variance 64

// Transition matrix over p, v, tilt, rate, d, m.
struct Transition {
  static constexpr std::array<std::string_view, 6> kRows{"1xxxxx", "0xxxxx", "00xx0x", "00xx0x", "000010", "000001"};
};
struct MeasuresPose {
  static constexpr std::string_view kRow = "1x00x0";
};
struct MeasuresTilt {
  static constexpr std::string_view kRow = "001x00";
};
struct MeasuresRate {
  static constexpr std::string_view kRow = "000100";
};

/// tan(t) = t (1 - t^2/9 + t^4/945) / (1 - 4 t^2/9 + t^4/63), the [5/4] Pade approximant.
template <typename S>
S tangent_of(core::Arithmetic<S>& a, S t) {
  const auto number = [](double value) { return core::Arithmetic<S>::template number<double>(value); };
  const S t2 = a.narrow(a.product(t, t));
  const S t4 = a.narrow(a.product(t2, t2));
  const auto one = a.widen(number(1.0));
  const S top = a.narrow(one - a.product(t2, number(1.0 / 9.0)) + a.product(t4, number(1.0 / 945.0)));
  const S bottom = a.narrow(one - a.product(t2, number(4.0 / 9.0)) + a.product(t4, number(1.0 / 63.0)));
  return a.quotient(a.narrow(a.product(t, top)), bottom);
}

}  // namespace

template <typename S>
[[gnu::cold]] void AxisFilter<S>::start(S tilt) {
  x_ = {};
  x_[kTilt] = tilt;
  std::array<double, kStates> variance;
  variance.fill(kInitialSigmas * kInitialSigmas);
  covariance_.set_diagonal(variance);
  history_ = {};
  angular_acceleration_ = S{};
  clamp_states();
}

template <typename S>
void AxisFilter<S>::clamp_states() {
  unroll<kStates>([this](auto state) {
    constexpr std::size_t i = decltype(state)::value;
    x_[i] = limited(x_[i], kLimits[i]);
  });
}

template <typename S>
void AxisFilter<S>::predict(const ActingInputs<S>& input) {
  auto& a = covariance_.arithmetic();
  const S tangent = tangent_of(a, x_[kTilt]);
  const S secant_squared =
      a.narrow(a.widen(core::Arithmetic<S>::template number<double>(1.0)) + a.product(tangent, tangent));
  const auto [tilt, rate] = response_.advance(a, {.output = x_[kTilt], .rate = x_[kRate]}, input, x_[kM]);
  model_response_ = response_.advance(a, model_response_, input, S{});
  angular_acceleration_ = a.narrow(a.scaled(a.widen(rate) - a.widen(x_[kRate]), -kTickExponent));

  const S turned = a.narrow(a.widen(tilt) - a.widen(x_[kTilt]));
  const S slope = a.narrow(a.product(c_.half_gravity, secant_squared));
  const S v = x_[kV];
  const S speed = v < S{} ? a.narrow(-a.widen(v)) : v;
  const S quadratic = a.narrow(a.product(c_.square_drag, speed));
  const S acceleration = a.narrow(a.product(c_.gravity, tangent) + a.product(slope, turned) - a.product(c_.drag, v) -
                                  a.product(quadratic, v));
  const auto pushed = a.widen(acceleration) + a.widen(x_[kD]);
  x_[kP] = a.narrow(a.widen(x_[kP]) + a.scaled(a.widen(v), kTickExponent) + a.scaled(pushed, 2 * kTickExponent - 1));
  x_[kV] = a.narrow(a.widen(v) + a.scaled(pushed, kTickExponent));
  history_.add(acceleration);

  phi_[kV][kV] = a.narrow(a.widen(c_.tick_drag) - a.product(c_.tick_square_drag, speed));
  phi_[kV][kTilt] = a.narrow(a.product(c_.v_tilt, secant_squared));
  phi_[kV][kRate] = a.narrow(a.product(c_.v_rate, secant_squared));
  phi_[kV][kM] = a.narrow(a.product(c_.v_m, secant_squared));
  const int halfway = kTickExponent - 1 + scales_[kV] - scales_[kP];  // position moves by T/2 times what velocity does
  for (const int i : {kTilt, kRate, kM}) {
    const auto j = static_cast<std::size_t>(i);
    phi_[kP][j] = a.narrow(a.scaled(a.widen(phi_[kV][j]), halfway));
  }
  covariance_.template predict<Transition>(phi_, q_);
  x_[kTilt] = tilt;
  x_[kRate] = rate;
  clamp_states();
}

template <typename S>
void AxisFilter<S>::fuse_specific_force(S disturbance, DisturbanceUse use) {
  if (use == DisturbanceUse::kHeld) {
    return;
  }
  auto& a = covariance_.arithmetic();
  const S v = x_[kV];
  const S speed = v < S{} ? a.narrow(-a.widen(v)) : v;
  const S quadratic = a.narrow(a.product(c_.square_drag, speed));
  const S now = a.narrow(a.widen(disturbance) + a.product(c_.drag, v) + a.product(quadratic, v));
  if (use == DisturbanceUse::kTracked) {
    const S offset = core::Arithmetic<S>::template number<double>(kForceOffset_m_s2 / kAccelerationUnit_m_s2);
    const S least = a.narrow(a.widen(now) - a.widen(offset));
    const S most = a.narrow(a.widen(now) + a.widen(offset));
    const S moved = a.narrow(a.widen(x_[kD]) + a.widen(now) - a.widen(stored_disturbance_));
    x_[kD] = limited(moved < least ? least : moved > most ? most : moved, kDisturbanceLimit);
  }
  stored_disturbance_ = now;
}

template <typename S>
void AxisFilter<S>::apply(const typename ScaledCovariance<S, kStates>::Column& gain, S innovation, int measured) {
  add_correction(covariance_.arithmetic(), x_, gain, innovation, scales_, measured);
}

template <typename S>
FusionResult AxisFilter<S>::fuse_attitude(S tilt, S rate, const MeasurementAge<S>& age) {
  auto& a = covariance_.arithmetic();
  typename ScaledCovariance<S, kStates>::Column h{};
  // Expected at the age a: tilt - a rate + a^2/2 rate', and rate - a rate'.
  const S turned = a.narrow(a.product(age.units, x_[kRate]) - a.product(age.half_square, angular_acceleration_));
  const S spun = a.narrow(a.product(age.units, angular_acceleration_));
  const S tilt_error = a.narrow(a.widen(tilt) - a.widen(x_[kTilt]) + a.widen(turned));
  const S rate_error = a.narrow(a.widen(rate) - a.widen(x_[kRate]) + a.widen(spun));
  constexpr double kTiltGate_rad = 0.35;
  constexpr double kRateGate = 5.0 * kTimeUnit_s;
  if (!(limited(tilt_error, kTiltGate_rad) == tilt_error) || !(limited(rate_error, kRateGate) == rate_error)) {
    return FusionResult::kRefused;
  }
  h[kRate] = a.narrow(-a.product(age.units, c_.tilt_rate));
  apply(covariance_.update(covariance_.template project<MeasuresTilt>(h, c_.tilt_variance)), tilt_error, kTilt);
  // The rate's innovation, from the state after the correction by the tilt.
  const S rate_left = a.narrow(a.widen(rate) - a.widen(x_[kRate]) + a.widen(spun));
  apply(covariance_.update(covariance_.template project<MeasuresRate>(h, c_.rate_variance)), rate_left, kRate);
  clamp_states();
  return FusionResult::kUsed;
}

template <typename S>
typename AxisFilter<S>::PoseInnovation AxisFilter<S>::test_pose(S position, const MeasurementAge<S>& age, S unseen_m,
                                                                float sender_variance_m2) {
  auto& a = covariance_.arithmetic();
  PoseInnovation test;
  typename ScaledCovariance<S, kStates>::Column h{};
  h[kV] = a.narrow(-a.product(age.units, c_.pose_rate));
  h[kD] = a.narrow(a.product(age.half_square, c_.pose_d));
  test.noise = larger_variance(c_.pose_variance, sender_variance_m2, scales_[kP], kMaxFixedPose);
  test.projection = covariance_.template project<MeasuresPose>(h, test.noise);
  const auto expected = a.widen(x_[kP]) - a.product(age.units, x_[kV]) + a.product(age.half_square, x_[kD]) +
                        a.widen(history_.displacement(a, age.ticks));
  test.innovation = a.narrow(a.widen(position) - expected);
  test.scale = scales_[kP];
  test.inside = inside_gate(a, test.innovation, test.projection.s, test.noise, test.scale, unseen_m);
  return test;
}

template <typename S>
void AxisFilter<S>::fuse_pose(const PoseInnovation& test) {
  apply(covariance_.update(test.projection), test.innovation, kP);
  clamp_states();
}

template <typename S>
[[gnu::cold]] void AxisFilter<S>::reset_position(S position, S velocity, const MeasurementAge<S>& age,
                                                 const MotionVariance& variance) {
  auto& a = covariance_.arithmetic();
  x_[kV] = velocity;
  x_[kP] = a.narrow(a.widen(position) + a.product(age.units, x_[kV]) - a.product(age.half_square, x_[kD]) -
                    a.widen(history_.displacement(a, age.ticks)));
  const S initial = core::Arithmetic<S>::template number<double>(kInitialSigmas * kInitialSigmas);
  covariance_.decouple(kP, larger_variance(initial, variance.position_m2, scales_[kP], kMaxFixedReset));
  covariance_.decouple(kV, larger_variance(initial, variance.velocity_m2, scales_[kV], kMaxFixedReset));
  clamp_states();
}

template <typename S>
bool AxisFilter<S>::is_sane() const {
  bool sane = true;
  unroll<kStates>([&](auto state) {
    constexpr std::size_t i = decltype(state)::value;
    const S variance = covariance_(state, state);
    sane = sane && inside(x_[i], kLimits[i]) && variance > S{} &&
           variance < core::Arithmetic<S>::template number<double>(1.2 * decltype(covariance_)::kCeiling);
  });
  return sane;
}

template class AxisFilter<double>;
template class AxisFilter<float>;
template class AxisFilter<core::Fixed>;

}  // namespace m100::est
