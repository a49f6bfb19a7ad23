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

/// Starts the filter when an attitude is known and a row of agreeing poses spans kBaseline. These poses also give the
/// initial velocity.
template <typename S, typename Real>
void DisturbanceEkf<S, Real>::begin(const core::Pose<Real>& pose) {
  using Number = core::Arithmetic<S>;
  if (!attitude_.is_known || !agreement_.add(pose, now_) || agreement_.span(pose, now_) < kBaseline) {
    return;
  }
  yaw_.start(Number::template number<Real>(wrapped_yaw(pose)));
  attitude_.angles.yaw_rad = Number::template real<Real>(yaw_.yaw());
  const core::Tilt<Real> tilt = core::tilt_of(attitude_.angles);
  const core::Vector<Real, 3> velocity = agreement_.velocity(pose, now_, tilt.x_rad, tilt.y_rad);
  const Real age_units = core::seconds<Real>(pose.age(now_)) / static_cast<Real>(kTimeUnit_s);
  const core::Vector<Real, 3> position = pose.position_w_m + velocity * age_units;
  x_.start(Number::template number<Real>(position.x()), Number::template number<Real>(velocity.x()),
           Number::template number<Real>(tilt.x_rad));
  y_.start(Number::template number<Real>(position.y()), Number::template number<Real>(velocity.y()),
           Number::template number<Real>(tilt.y_rad));
  height_.start(Number::template number<Real>(position.z()), Number::template number<Real>(velocity.z()));
  started_ = true;
  since_start_ = core::Duration(0);
  ++counters_.poses_used;
  record_used(pose, true);
}

template <typename S, typename Real>
void DisturbanceEkf<S, Real>::check_reset(const core::Pose<Real>& pose, const MeasurementAge<S>& age) {
  using Number = core::Arithmetic<S>;
  const bool follows = agreement_.add(pose, now_);
  const core::Duration agreeing_for = agreement_.span(pose, now_);
  const bool dropped_out = pose_.since_use > kDropout + agreeing_for;
  const std::uint32_t needed = dropped_out ? kAgreeingAfterDropout : kAgreeingPoses;
  if (!follows || agreement_.count() < needed || agreeing_for < (dropped_out ? kBaseline : kAgreeingFor) ||
      (!dropped_out && since_recovery_ < kResetSpacing)) {
    return;
  }
  recover(dropped_out ? ResetReason::kLongDropout : ResetReason::kPoseMoved);
  using Filter = AxisFilter<S>;
  const core::Vector<Real, 3> velocity =
      agreement_.velocity(pose, now_, Number::template real<Real>(x_.state(Filter::kTilt)),
                          Number::template real<Real>(y_.state(Filter::kTilt)));
  const auto number = [](Real value) { return Number::template number<Real>(value); };
  x_.reset_position(number(pose.position_w_m.x()), number(velocity.x()), age);
  y_.reset_position(number(pose.position_w_m.y()), number(velocity.y()), age);
  height_.reset_position(number(pose.position_w_m.z()), number(velocity.z()), age);
  const bool turns = heading_reset_ == HeadingReset::kFree;
  if (turns) {
    yaw_.reset_position(number(wrapped_yaw(pose)));
  }
  record_used(pose, turns);
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
  x_.start(S{}, S{}, S{});
  y_.start(S{}, S{}, S{});
  height_.start(S{}, S{});
  yaw_.start(S{});
  attitude_.yaw_rate = S{};
}

#define M100_INSTANTIATE(S, Real)                                                                        \
  template void DisturbanceEkf<S, Real>::begin(const core::Pose<Real>&);                                 \
  template void DisturbanceEkf<S, Real>::check_reset(const core::Pose<Real>&, const MeasurementAge<S>&); \
  template void DisturbanceEkf<S, Real>::recover(ResetReason);                                           \
  template void DisturbanceEkf<S, Real>::restart();
M100_INSTANTIATE(double, double)
M100_INSTANTIATE(float, float)
M100_INSTANTIATE(core::Fixed, float)
#undef M100_INSTANTIATE

}  // namespace m100::est
