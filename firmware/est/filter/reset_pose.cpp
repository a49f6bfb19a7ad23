// SPDX-License-Identifier: BSD-3-Clause
// Starts the observer, and recovers it when the gate has refused the poses.
#include "firmware/est/filter/reset_pose.h"

#include "firmware/core/tilt.h"
#include "firmware/est/filter/disturbance_ekf.h"
#include "firmware/est/filter/units.h"

namespace m100::est {
namespace {

using std::chrono::milliseconds;

constexpr std::uint32_t kAgreeingPoses = 10;
constexpr core::Duration kAgreeingFor = milliseconds(500);  // longer than Limits::gate_shut: the failsafe reacts first
constexpr std::uint32_t kAgreeingAfterDropout = 3;
constexpr core::Duration kBaseline = milliseconds(100);  // least time between two poses that give a velocity

}  // namespace

/// Sets position, velocity and, if `with_heading`, yaw from the newest of a row of agreeing poses. With poses of
/// variance r, the velocity (newest - first) / span has the variance 2 r / span^2, and the position, newest + age
/// velocity, has r ((1 + age/span)^2 + (age/span)^2). Their covariance is left out; twice the variances bound what it
/// adds.
template <typename S, typename Real>
void DisturbanceEkf<S, Real>::set_motion(const core::Pose<Real>& pose, const MeasurementAge<S>& age,
                                         bool with_heading) {
  using Number = core::Arithmetic<S>;
  using Filter = AxisFilter<S>;
  const auto number = [](Real value) { return Number::template number<Real>(value); };
  const core::Vector<Real, 3> velocity =
      agreement_.velocity(pose, now_, Number::template real<Real>(x_.state(Filter::kTilt)),
                          Number::template real<Real>(y_.state(Filter::kTilt)));
  const auto span_units = static_cast<float>(core::seconds<double>(agreement_.span(pose, now_)) / kTimeUnit_s);
  const float share = Number::template real<float>(age.units) / span_units;
  const auto set = [&](auto& filter, Eigen::Index axis) {
    const auto twice_m2 = static_cast<float>(Real(2) * pose.position_variance_m2[axis]);
    filter.reset_position(number(pose.position_w_m[axis]), number(velocity[axis]), age,
                          {.position_m2 = twice_m2 * (1.F + 2.F * share * (1.F + share)),
                           .velocity_m2 = 2.F * twice_m2 / (span_units * span_units)});
  };
  set(x_, 0);
  set(y_, 1);
  set(height_, 2);
  if (with_heading) {
    yaw_.reset_position(number(wrapped_yaw(pose)));
  }
  record_used(pose, with_heading);
}

/// Starts the filter when an attitude is known and a row of agreeing poses spans kBaseline. These poses also give the
/// initial velocity.
template <typename S, typename Real>
void DisturbanceEkf<S, Real>::begin(const core::Pose<Real>& pose, const MeasurementAge<S>& age) {
  using Number = core::Arithmetic<S>;
  if (!attitude_.is_known || !agreement_.add(pose, now_) || agreement_.span(pose, now_) < kBaseline) {
    return;
  }
  yaw_.start(Number::template number<Real>(wrapped_yaw(pose)));
  attitude_.angles.yaw_rad = Number::template real<Real>(yaw_.yaw());
  const core::Tilt<Real> tilt = core::tilt_of(attitude_.angles);
  x_.start(Number::template number<Real>(tilt.x_rad));
  y_.start(Number::template number<Real>(tilt.y_rad));
  height_.start();
  set_motion(pose, age, true);
  started_ = true;
  since_start_ = core::Duration(0);
  ++counters_.poses_used;
}

template <typename S, typename Real>
void DisturbanceEkf<S, Real>::check_reset(const core::Pose<Real>& pose, const MeasurementAge<S>& age) {
  const bool follows = agreement_.add(pose, now_);
  const core::Duration agreeing_for = agreement_.span(pose, now_);
  const bool dropped_out = pose_.since_use > kDropout + agreeing_for;
  const std::uint32_t needed = dropped_out ? kAgreeingAfterDropout : kAgreeingPoses;
  if (!follows || agreement_.count() < needed || agreeing_for < (dropped_out ? kBaseline : kAgreeingFor) ||
      (!dropped_out && since_recovery_ < kResetSpacing)) {
    return;
  }
  recover(dropped_out ? ResetReason::kLongDropout : ResetReason::kPoseMoved);
  set_motion(pose, age, pose_.heading_reset == HeadingReset::kFree);
}

template <typename S, typename Real>
void DisturbanceEkf<S, Real>::recover(ResetReason reason) {
  ++counters_.recoveries;
  counters_.last_recovery = reason;
  since_recovery_ = core::Duration(0);
}

template <typename S, typename Real>
void DisturbanceEkf<S, Real>::restart() {
  started_ = false;
  attitude_.is_known = false;
  attitude_.refused_in_a_row = 0;
  pose_.refused_in_a_row = 0;
  agreement_.end_row();
  x_.start(S{});
  y_.start(S{});
  height_.start();
  yaw_.start(S{});
  attitude_.yaw_rate = S{};
}

#define M100_INSTANTIATE(S, Real)                                                                        \
  template void DisturbanceEkf<S, Real>::begin(const core::Pose<Real>&, const MeasurementAge<S>&);       \
  template void DisturbanceEkf<S, Real>::check_reset(const core::Pose<Real>&, const MeasurementAge<S>&); \
  template void DisturbanceEkf<S, Real>::recover(ResetReason);                                           \
  template void DisturbanceEkf<S, Real>::restart();
M100_INSTANTIATE(double, double)
M100_INSTANTIATE(float, float)
M100_INSTANTIATE(core::Fixed, float)
#undef M100_INSTANTIATE

}  // namespace m100::est
