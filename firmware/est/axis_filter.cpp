// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/axis_filter.h"

#include "firmware/core/maths.h"
#include "firmware/est/units.h"

namespace m100::est {
namespace {

constexpr double kGateSigmas = 6.0;
constexpr double kTiltLimit_rad = 0.7;  // the tangent below is good to 4e-9 up to here
constexpr double kRateLimit = 10.0 * kTimeUnit_s;
constexpr double kVelocityLimit = 25.0 * kTimeUnit_s;
constexpr double kDisturbanceLimit = 8.0 * kTimeUnit_s * kTimeUnit_s;
constexpr double kOffsetLimit_rad = 0.3;
constexpr double kPositionLimit_m = 100.0;
constexpr double kInitialSigmas = 8.0;  // over the scale: variance 64
constexpr double kLargestInnovation_m = 1.0;
constexpr double kScaledInnovationLimit = 90.0;  // its square fits beside the variances

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

constexpr double power_of_two(int exponent) {
  double value = 1.0;
  for (int i = 0; i < exponent; ++i) {
    value *= 2.0;
  }
  for (int i = 0; i > exponent; --i) {
    value *= 0.5;
  }
  return value;
}

constexpr int exponent_above(double value) {
  int exponent = -20;
  while (exponent < 6 && power_of_two(exponent) < value) {
    ++exponent;
  }
  return exponent + 2;  // headroom
}

template <typename S>
S limited(S value, double limit) {
  const S high = core::Arithmetic<S>::template number<double>(limit);
  const S low = core::Arithmetic<S>::template number<double>(-limit);
  return value > high ? high : (value < low ? low : value);
}

}  // namespace

template <typename S>
AxisFilter<S>::AxisFilter(const AxisModel& model) : AxisFilter(model, steady_scales(model)) {}

template <typename S>
AxisFilter<S>::AxisFilter(const AxisModel& model, const Scales& scales) : scales_(scales) {
  const auto number = [](double value) { return core::Arithmetic<S>::template number<double>(value); };
  const auto ratio = [&](int from, int to) {  // scaled entry = entry * 2^(e_from - e_to)
    return power_of_two(scales_[static_cast<std::size_t>(from)] - scales_[static_cast<std::size_t>(to)]);
  };
  const AttitudeStep step = discretise(model.attitude, kTick_s);
  const double o_r = step.o_r / kTimeUnit_s, ro = step.ro * kTimeUnit_s;
  const double r_u = step.r_u * kTimeUnit_s, r_next = step.r_next * kTimeUnit_s;
  const double r_m = r_u + r_next;
  const double tick = power_of_two(kTickExponent);
  const double gravity = model.tilt_sign * model.tilt_gain * model::kGravity_m_s2 / kAccelerationUnit_m_s2;
  const double drag = model.linear_drag_per_s * kTimeUnit_s;

  c_.oo = number(step.oo);
  c_.o_r = number(o_r);
  c_.o_u = number(step.o_u);
  c_.o_jump = number(step.o_jump);
  c_.ro = number(ro);
  c_.rr = number(step.rr);
  c_.r_u = number(r_u);
  c_.r_next = number(r_next);
  c_.r_jump = number(step.r_jump * kTimeUnit_s);
  c_.r_m = number(r_m);
  c_.gravity = number(gravity);
  c_.half_gravity = number(0.5 * gravity);
  c_.drag = number(drag);
  c_.quadratic_drag = number(model.quadratic_drag_per_m);

  // d(acceleration)/d(tilt, rate, m) = g / cos^2(tilt) (1 + oo, o_r, o_u) / 2: the slope at the middle of the tick.
  c_.v_tilt = number(tick * gravity * 0.5 * (1.0 + step.oo) * ratio(kTilt, kV));
  c_.v_rate = number(tick * gravity * 0.5 * o_r * ratio(kRate, kV));
  c_.v_m = number(tick * gravity * 0.5 * step.o_u * ratio(kM, kV));
  c_.tick_drag = number(1.0 - tick * drag);
  c_.tick_quadratic_drag = number(2.0 * tick * model.quadratic_drag_per_m);

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
  start(S{}, S{}, S{});
}

template <typename S>
void AxisFilter<S>::start(S position, S velocity, S tilt) {
  x_ = {};
  x_[kP] = position;
  x_[kV] = velocity;
  x_[kTilt] = tilt;
  std::array<double, kStates> variance;
  variance.fill(kInitialSigmas * kInitialSigmas);
  covariance_.set_diagonal(variance);
  history_ = {};
  angular_acceleration_ = S{};
  clamp_states();
  set_tangent();
}

// tan(t) = t (1 - t^2/9 + t^4/945) / (1 - 4 t^2/9 + t^4/63), the [5/4] Pade approximant.
template <typename S>
void AxisFilter<S>::set_tangent() {
  auto& a = covariance_.arithmetic();
  const auto number = [](double value) { return core::Arithmetic<S>::template number<double>(value); };
  const S t = x_[kTilt];
  const S t2 = a.narrow(a.product(t, t));
  const S t4 = a.narrow(a.product(t2, t2));
  const auto one = a.widen(number(1.0));
  const S top = a.narrow(one - a.product(t2, number(1.0 / 9.0)) + a.product(t4, number(1.0 / 945.0)));
  const S bottom = a.narrow(one - a.product(t2, number(4.0 / 9.0)) + a.product(t4, number(1.0 / 63.0)));
  tangent_ = a.quotient(a.narrow(a.product(t, top)), bottom);
  secant_squared_ = a.narrow(one + a.product(tangent_, tangent_));
}

template <typename S>
void AxisFilter<S>::clamp_states() {
  x_[kP] = limited(x_[kP], kPositionLimit_m);
  x_[kV] = limited(x_[kV], kVelocityLimit);
  x_[kTilt] = limited(x_[kTilt], kTiltLimit_rad);
  x_[kRate] = limited(x_[kRate], kRateLimit);
  x_[kD] = limited(x_[kD], kDisturbanceLimit);
  x_[kM] = limited(x_[kM], kOffsetLimit_rad);
}

template <typename S>
void AxisFilter<S>::predict(S input, S input_before, S input_after) {
  auto& a = covariance_.arithmetic();
  const S wanted = a.narrow(a.widen(input) + a.widen(x_[kM]));
  const S wanted_after = a.narrow(a.widen(input_after) + a.widen(x_[kM]));
  const S jump = a.narrow(a.widen(input) - a.widen(input_before));
  const S tilt = a.narrow(a.product(c_.oo, x_[kTilt]) + a.product(c_.o_r, x_[kRate]) + a.product(c_.o_u, wanted) +
                          a.product(c_.o_jump, jump));
  const S rate = a.narrow(a.product(c_.ro, x_[kTilt]) + a.product(c_.rr, x_[kRate]) + a.product(c_.r_u, wanted) +
                          a.product(c_.r_next, wanted_after) + a.product(c_.r_jump, jump));
  angular_acceleration_ = a.narrow(a.scaled(a.widen(rate) - a.widen(x_[kRate]), -kTickExponent));

  const S turned = a.narrow(a.widen(tilt) - a.widen(x_[kTilt]));
  const S slope = a.narrow(a.product(c_.half_gravity, secant_squared_));
  const S v = x_[kV];
  const S speed = v < S{} ? a.narrow(-a.widen(v)) : v;
  const S quadratic = a.narrow(a.product(c_.quadratic_drag, speed));
  const S acceleration = a.narrow(a.product(c_.gravity, tangent_) + a.product(slope, turned) - a.product(c_.drag, v) -
                                  a.product(quadratic, v));
  const auto pushed = a.widen(acceleration) + a.widen(x_[kD]);
  x_[kP] = a.narrow(a.widen(x_[kP]) + a.scaled(a.widen(v), kTickExponent) + a.scaled(pushed, 2 * kTickExponent - 1));
  x_[kV] = a.narrow(a.widen(v) + a.scaled(pushed, kTickExponent));
  history_.push(acceleration);

  phi_[kV][kV] = a.narrow(a.widen(c_.tick_drag) - a.product(c_.tick_quadratic_drag, speed));
  phi_[kV][kTilt] = a.narrow(a.product(c_.v_tilt, secant_squared_));
  phi_[kV][kRate] = a.narrow(a.product(c_.v_rate, secant_squared_));
  phi_[kV][kM] = a.narrow(a.product(c_.v_m, secant_squared_));
  const int halfway = kTickExponent - 1 + scales_[kV] - scales_[kP];  // position moves by T/2 times what velocity does
  for (const int i : {kTilt, kRate, kM}) {
    const auto j = static_cast<std::size_t>(i);
    phi_[kP][j] = a.narrow(a.scaled(a.widen(phi_[kV][j]), halfway));
  }
  covariance_.template predict<Transition>(phi_, q_);
  x_[kTilt] = tilt;
  x_[kRate] = rate;
  clamp_states();
  set_tangent();
}

template <typename S>
void AxisFilter<S>::apply(const typename ScaledCovariance<S, kStates>::Column& gain, S innovation, int measured) {
  auto& a = covariance_.arithmetic();
  for (std::size_t i = 0; i < x_.size(); ++i) {
    // Gain first, in 64 bits, then the scale: a gain in plain units would not fit.
    const auto correction =
        a.scaled(a.product(gain[i], innovation), scales_[i] - scales_[static_cast<std::size_t>(measured)]);
    x_[i] = a.narrow(a.widen(x_[i]) + correction);
  }
}

template <typename S>
Verdict AxisFilter<S>::correct_attitude(S tilt, S rate, const Age<S>& age) {
  auto& a = covariance_.arithmetic();
  typename ScaledCovariance<S, kStates>::Column h{};
  // Seen: tilt - a rate + a^2/2 rate', rate - a rate'.
  const S turned = a.narrow(a.product(age.units, x_[kRate]) - a.product(age.half_square, angular_acceleration_));
  const S spun = a.narrow(a.product(age.units, angular_acceleration_));
  const S tilt_error = a.narrow(a.widen(tilt) - a.widen(x_[kTilt]) + a.widen(turned));
  const S rate_error = a.narrow(a.widen(rate) - a.widen(x_[kRate]) + a.widen(spun));
  constexpr double kTiltGate_rad = 0.35;
  constexpr double kRateGate = 5.0 * kTimeUnit_s;
  if (!(limited(tilt_error, kTiltGate_rad) == tilt_error) || !(limited(rate_error, kRateGate) == rate_error)) {
    ++attitude_refusals_;
    return Verdict::kRefused;
  }
  h[kRate] = a.narrow(-a.product(age.units, c_.tilt_rate));
  apply(covariance_.update(covariance_.template project<MeasuresTilt>(h, c_.tilt_variance)), tilt_error, kTilt);
  // The rate's innovation from the state as the tilt has just left it.
  const S rate_left = a.narrow(a.widen(rate) - a.widen(x_[kRate]) + a.widen(spun));
  apply(covariance_.update(covariance_.template project<MeasuresRate>(h, c_.rate_variance)), rate_left, kRate);
  clamp_states();
  covariance_.check();
  set_tangent();
  return Verdict::kUsed;
}

template <typename S>
typename AxisFilter<S>::PoseTest AxisFilter<S>::test_pose(S position, const Age<S>& age, S unseen_m) {
  auto& a = covariance_.arithmetic();
  PoseTest test;
  typename ScaledCovariance<S, kStates>::Column h{};
  h[kV] = a.narrow(-a.product(age.units, c_.pose_rate));
  h[kD] = a.narrow(a.product(age.half_square, c_.pose_d));
  test.projection = covariance_.template project<MeasuresPose>(h, c_.pose_variance);
  const auto expected = a.widen(x_[kP]) - a.product(age.units, x_[kV]) + a.product(age.half_square, x_[kD]) +
                        a.widen(history_.displacement(a, age.ticks));
  test.innovation = a.narrow(a.widen(position) - expected);
  const S size = test.innovation < S{} ? a.narrow(-a.widen(test.innovation)) : test.innovation;
  const S largest = core::Arithmetic<S>::template number<double>(kLargestInnovation_m);
  const S most_sigmas =
      core::Arithmetic<S>::template number<double>(kScaledInnovationLimit * power_of_two(scales_[kP]));
  bool inside_sigmas = false;
  if (size < most_sigmas) {
    const S scaled = a.narrow(a.scaled(a.widen(size), -scales_[kP]));
    const S gate = core::Arithmetic<S>::template number<double>(kGateSigmas * kGateSigmas);
    inside_sigmas = a.product(scaled, scaled) <= a.product(test.projection.s, gate);
  }
  test.inside = size <= largest && (inside_sigmas || size <= unseen_m);
  return test;
}

template <typename S>
void AxisFilter<S>::correct_pose(const PoseTest& test) {
  apply(covariance_.update(test.projection), test.innovation, kP);
  clamp_states();
  covariance_.check();
  set_tangent();
}

template <typename S>
void AxisFilter<S>::reanchor(S position, S velocity, const Age<S>& age) {
  auto& a = covariance_.arithmetic();
  x_[kV] = velocity;
  x_[kP] = a.narrow(a.widen(position) + a.product(age.units, x_[kV]) - a.product(age.half_square, x_[kD]) -
                    a.widen(history_.displacement(a, age.ticks)));
  covariance_.decouple(kP, kInitialSigmas * kInitialSigmas);
  covariance_.decouple(kV, kInitialSigmas * kInitialSigmas);
  clamp_states();
}

template <typename S>
bool AxisFilter<S>::is_sane() const {
  const auto inside = [this](int i, double limit) {  // false for NaN
    const S value = x_[static_cast<std::size_t>(i)];
    return value <= core::Arithmetic<S>::template number<double>(limit) &&
           value >= core::Arithmetic<S>::template number<double>(-limit);
  };
  bool sane = inside(kP, kPositionLimit_m) && inside(kV, kVelocityLimit) && inside(kTilt, kTiltLimit_rad) &&
              inside(kRate, kRateLimit) && inside(kD, kDisturbanceLimit) && inside(kM, kOffsetLimit_rad);
  const S ceiling = core::Arithmetic<S>::template number<double>(120.0);
  for (int i = 0; i < kStates; ++i) {
    const S variance = covariance_(i, i);
    sane = sane && variance > S{} && variance < ceiling;
  }
  return sane;
}

AxisFilter<double>::Scales steady_scales(const AxisModel& model) {
  using Filter = AxisFilter<double>;
  // With rough sigmas first: the limits on scaled variances must not bind while the filter settles.
  constexpr Filter::Scales kRough{-8, -5, -6, -2, -2, -5};
  Filter filter(model, kRough);
  const Age<double> pose_age = Age<double>::of(0.02);
  const Age<double> attitude_age = Age<double>::of(0.0);
  for (int tick = 0; tick < 500; ++tick) {
    filter.predict(0.0, 0.0, 0.0);
    filter.correct_attitude(0.0, 0.0, attitude_age);
    filter.correct_pose(filter.test_pose(0.0, pose_age, 0.0));
  }
  Filter::Scales scales{};
  for (int i = 0; i < Filter::kStates; ++i) {
    const auto j = static_cast<std::size_t>(i);
    scales[j] = exponent_above(core::sqrt(filter.scaled_covariance(i, i)) * power_of_two(kRough[j]));
  }
  return scales;
}

template class AxisFilter<double>;
template class AxisFilter<float>;
template class AxisFilter<core::Fixed>;

}  // namespace m100::est
