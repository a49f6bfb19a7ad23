// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/filter/height_filter.h"

#include <array>

namespace m100::est {
namespace {

// Process noise per sqrt(s), found together with the gains of ctl/law/altitude_pid.cpp: of all with which every
// corner keeps 6 dB and 45 degrees, those with the least error in hover.
// The autopilot's climb loop has an error of about 0.07 m/s in still air.
constexpr std::array kProcess{1e-3, 0.47, 0.51, 0.025};
template <typename S>
constexpr typename Kalman<S, 4>::Limits kLimits{S(100.0), S(10.0), S(50.0), S(1.0)};
constexpr std::array kInitialSigma{0.13, 0.8, 4.9, 0.8};

/// H v of a height of a time ago.
template <typename S>
auto height_of(S age_s) {
  using Filter = HeightFilter<S>;
  return [age_s](const auto& v) -> S { return v(Filter::kZ) - v(Filter::kClimb) * age_s; };
}

}  // namespace

template <typename S>
[[gnu::cold]] HeightFilter<S>::HeightFilter(const model::StickAxis& climb, double pose_sigma_m)
    : response_(ResponseStep<S>::of(tick_of(climb))), pose_variance_{S(pose_sigma_m * pose_sigma_m)} {
  q_ = (core::Vector<double, kStates>(kProcess.data()).cwiseAbs2() * kTick_s).template cast<S>();
  start();
}

template <typename S>
[[gnu::cold]] void HeightFilter<S>::start() {
  filter_.start(core::Vector<double, kStates>(kInitialSigma.data()));
  history_ = {};
}

template <typename S>
void HeightFilter<S>::predict(const ActingInputs<S>& input) {
  auto& x = filter_.x;
  const auto next = response_.advance({.output = x(kClimb), .rate = x(kRate)}, input, x(kOffset));
  history_.add((next.output - x(kClimb)) * S(1.0 / kTick_s));
  x(kZ) += (x(kClimb) + next.output) * S(0.5 * kTick_s);
  x(kClimb) = next.output;
  x(kRate) = next.rate;
  const S rate_per_offset = response_.r_u + response_.r_next;
  filter_.predict(
      [&](const auto& v) {  // F v
        const S climb = response_.oo * v(kClimb) + response_.o_r * v(kRate) + response_.o_u * v(kOffset);
        const S rate = response_.ro * v(kClimb) + response_.rr * v(kRate) + rate_per_offset * v(kOffset);
        return core::Vector<S, kStates>{v(kZ) + (v(kClimb) + climb) * S(0.5 * kTick_s), climb, rate, v(kOffset)};
      },
      q_);
  filter_.clamp(kLimits<S>);
}

template <typename S>
PoseInnovation<S> HeightFilter<S>::test_pose(S height_m, S age_s, S unseen_m, S sender_variance_m2) const {
  const S noise_m2 = sender_variance_m2 > pose_variance_ ? sender_variance_m2 : pose_variance_;
  return est::test_pose(filter_, height_of(age_s), height_m, age_s, history_.displacement(age_s), noise_m2, unseen_m);
}

template <typename S>
void HeightFilter<S>::fuse_pose(const PoseInnovation<S>& test) {
  const core::Vector<S, kStates> gain = filter_.correct_joseph(height_of(test.age_s), test.innovation_m, test.noise_m2);
  gain_ = gain(kZ);
  climb_gain_ = gain(kClimb);
  pose_height_variance_ = gain(kZ) * test.noise_m2;
  filter_.clamp(kLimits<S>);
}

template <typename S>
[[gnu::cold]] void HeightFilter<S>::reset_position(S height_m, S climb_m_s, S age_s, const MotionVariance& variance) {
  filter_.x(kClimb) = climb_m_s;
  filter_.x(kZ) = height_m + age_s * climb_m_s - history_.displacement(age_s);
  filter_.decouple(kZ, variance.position_m2, kInitialSigma[kZ], kLimits<S>[kZ]);
  filter_.decouple(kClimb, variance.velocity_m2_s2, kInitialSigma[kClimb], kLimits<S>[kClimb]);
  filter_.clamp(kLimits<S>);
}

template <typename S>
bool HeightFilter<S>::is_sane() const {
  return filter_.is_valid();
}

template class HeightFilter<double>;
template class HeightFilter<float>;
template class HeightFilter<core::Fixed>;

}  // namespace m100::est
