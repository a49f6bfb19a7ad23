// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/filter/height_filter.h"

#include <string_view>

#include "firmware/est/filter/units.h"

namespace m100::est {
namespace {

// Process noise per sqrt(s), found together with the gains of ctl/law/altitude_pid.cpp: of all with which every
// corner keeps 6 dB and 45 degrees, those with the least error in hover.
// The autopilot's climb loop has an error of about 0.07 m/s in still air.
constexpr double kHeightProcess_m = 1e-3, kClimbProcess_m_s = 0.47, kRateProcess_m_s2 = 0.51;
constexpr double kOffsetProcess_m_s = 0.025;
/// Of the states: 100 m, 10 m/s, 50 m/s^2 and 1 m/s.
constexpr std::array kLimits{100.0, 10.0 * kTimeUnit_s, 50.0 * kTimeUnit_s* kTimeUnit_s, 1.0 * kTimeUnit_s};

// Scales: a state's unit in the covariance is 2^scale. The first poses stay below the ceiling when they are 250 ms old,
// and with a climb time constant of 10 ms. At the start the sigmas are 0.13 m, 0.8 m/s, 4.9 m/s^2 and 0.8 m/s.
constexpr std::array<int, 4> kScale{HeightFilter<float>::kHeightScale, -4, 1, -4};
constexpr std::array kInitialVariance{16.0, 64.0, 1.0, 64.0};

struct Transition {
  static constexpr std::array<std::string_view, 4> kRows{"1xxx", "0xxx", "0xxx", "0001"};
};
struct MeasuresHeight {
  static constexpr std::string_view kRow = "1x00";
};

}  // namespace

template <typename S>
[[gnu::cold]] HeightFilter<S>::HeightFilter(const model::StickAxis& climb, double pose_sigma_m) {
  const auto number = [](double value) { return core::Arithmetic<S>::template number<double>(value); };
  const model::AxisStep step = tick_of(climb);
  const double o_r = step.o_r / kTimeUnit_s, ro = step.ro * kTimeUnit_s;
  response_ = ResponseStep<S>::of(step);
  const auto ratio = [](std::size_t from, std::size_t to) { return power_of_two(kScale[from] - kScale[to]); };
  const double half_tick = 0.5 * kTick_s / kTimeUnit_s;
  // z+ = z + T (w + w+) / 2
  phi_[kZ][kClimb] = number(half_tick * (1.0 + step.oo) * ratio(kClimb, kZ));
  phi_[kZ][kRate] = number(half_tick * o_r * ratio(kRate, kZ));
  phi_[kZ][kOffset] = number(half_tick * step.o_u * ratio(kOffset, kZ));
  phi_[kClimb][kClimb] = response_.oo;
  phi_[kClimb][kRate] = number(o_r * ratio(kRate, kClimb));
  phi_[kClimb][kOffset] = number(step.o_u * ratio(kOffset, kClimb));
  phi_[kRate][kClimb] = number(ro * ratio(kClimb, kRate));
  phi_[kRate][kRate] = response_.rr;
  phi_[kRate][kOffset] = number((step.r_u + step.r_next) * kTimeUnit_s * ratio(kOffset, kRate));
  const double sigma[] = {kHeightProcess_m, kClimbProcess_m_s * kTimeUnit_s,
                          kRateProcess_m_s2 * kTimeUnit_s * kTimeUnit_s, kOffsetProcess_m_s * kTimeUnit_s};
  for (std::size_t i = 0; i < q_.size(); ++i) {
    const double scaled = sigma[i] * power_of_two(-kScale[i]);
    q_[i] = number(scaled * scaled * kTick_s);
  }
  const double pose = pose_sigma_m * power_of_two(-kScale[kZ]);
  pose_variance_ = number(pose * pose);
  pose_rate_ = number(ratio(kClimb, kZ));
  start();
}

template <typename S>
[[gnu::cold]] void HeightFilter<S>::start() {
  x_ = {};
  covariance_.set_diagonal(kInitialVariance);
  history_ = {};
}

template <typename S>
void HeightFilter<S>::clamp_states() {
  for (std::size_t i = 0; i < x_.size(); ++i) {
    x_[i] = limited(x_[i], kLimits[i]);
  }
}

template <typename S>
void HeightFilter<S>::predict(const ActingInputs<S>& input) {
  auto& a = covariance_.arithmetic();
  const auto next = response_.advance(a, {.output = x_[kClimb], .rate = x_[kRate]}, input, x_[kOffset]);
  const auto change = a.widen(next.output) - a.widen(x_[kClimb]);
  history_.add(a.narrow(a.scaled(change, -kTickExponent)));
  x_[kZ] = a.narrow(a.widen(x_[kZ]) + a.scaled(a.widen(x_[kClimb]) + a.widen(next.output), kTickExponent - 1));
  x_[kClimb] = next.output;
  x_[kRate] = next.rate;
  covariance_.template predict<Transition>(phi_, q_);
  clamp_states();
}

template <typename S>
typename HeightFilter<S>::PoseInnovation HeightFilter<S>::test_pose(S height, const MeasurementAge<S>& age, S unseen_m,
                                                                    float sender_variance_m2) {
  auto& a = covariance_.arithmetic();
  PoseInnovation test;
  const typename Covariance::Column h{S{}, a.narrow(-a.product(age.units, pose_rate_))};
  test.noise = larger_variance(pose_variance_, sender_variance_m2, kScale[kZ], kMaxFixedPose);
  test.projection = covariance_.template project<MeasuresHeight>(h, test.noise);
  const auto expected =
      a.widen(x_[kZ]) - a.product(age.units, x_[kClimb]) + a.widen(history_.displacement(a, age.ticks));
  test.innovation = a.narrow(a.widen(height) - expected);
  test.scale = kScale[kZ];
  test.inside = inside_gate(a, test.innovation, test.projection.s, test.noise, test.scale, unseen_m);
  return test;
}

template <typename S>
void HeightFilter<S>::fuse_pose(const PoseInnovation& test) {
  auto& a = covariance_.arithmetic();
  const auto gain = covariance_.update(test.projection);
  gain_ = gain[kZ];
  pose_height_variance_ = a.narrow(a.product(gain[kZ], test.noise));
  climb_gain_ = a.narrow(a.product(gain[kClimb], pose_rate_));
  add_correction(a, x_, gain, test.innovation, kScale, kZ);
  clamp_states();
  covariance_.check();
}

template <typename S>
[[gnu::cold]] void HeightFilter<S>::reset_position(S height, S climb, const MeasurementAge<S>& age,
                                                   const MotionVariance& variance) {
  auto& a = covariance_.arithmetic();
  x_[kClimb] = climb;
  x_[kZ] = a.narrow(a.widen(height) + a.product(age.units, x_[kClimb]) - a.widen(history_.displacement(a, age.ticks)));
  const auto initial = [](int state, float wanted) {
    const auto i = static_cast<std::size_t>(state);
    const S least = core::Arithmetic<S>::template number<double>(kInitialVariance[i]);
    return larger_variance(least, wanted, kScale[i], kMaxFixedReset);
  };
  covariance_.decouple(kZ, initial(kZ, variance.position_m2));
  covariance_.decouple(kClimb, initial(kClimb, variance.velocity_m2));
  clamp_states();
}

template <typename S>
bool HeightFilter<S>::is_sane() const {
  bool sane = true;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    const S variance = covariance_(static_cast<int>(i), static_cast<int>(i));
    sane = sane && inside(x_[i], kLimits[i]) && variance > S{} &&
           variance < core::Arithmetic<S>::template number<double>(1.2 * Covariance::kCeiling);
  }
  return sane;
}

template class HeightFilter<double>;
template class HeightFilter<float>;
template class HeightFilter<core::Fixed>;

}  // namespace m100::est
