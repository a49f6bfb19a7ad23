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
constexpr core::Duration kAgreeingFor =
    milliseconds(500);  // longer than the failsafe waits: the operator handles a jump
constexpr std::uint32_t kAgreeingAfterDropout = 3;
constexpr double kFastestFlight_m_s = 6.0;
constexpr double kAgreement_m = 0.03;
constexpr core::Duration kBaseline = milliseconds(100);  // for a velocity from two poses

}  // namespace

template <typename S, typename Real>
core::Vector<Real, 3> DisturbanceEkf<S, Real>::velocity_since_first(const core::Pose<Real>& pose, Real tilt_x_rad,
                                                                    Real tilt_y_rad) const {
  const Real span_s = core::seconds<Real>(since_first_ - pose.age(now_));
  constexpr Real kGravity = static_cast<Real>(model::kGravity_m_s2);
  const core::Vector<Real, 3> acceleration{kGravity * core::tan(tilt_x_rad), -kGravity * core::tan(tilt_y_rad),
                                           Real(0)};
  const Real later_s = Real(0.5) * span_s + core::seconds<Real>(pose.age(now_));  // from the middle of the span to now
  const core::Vector<Real, 3> velocity =
      (pose.position_w_m - first_pose_.position_w_m) / span_s + acceleration * later_s;
  return velocity * static_cast<Real>(kTimeUnit_s);
}

/// Starts the filter with the first pose that is kBaseline younger than an earlier one that it agrees with: a vehicle
/// that is already flying has a velocity.
template <typename S, typename Real>
void DisturbanceEkf<S, Real>::begin(const core::Pose<Real>& pose) {
  using Number = core::Arithmetic<S>;
  if (!attitude_known_ || !agrees(pose) || since_first_ - pose.age(now_) < kBaseline) {
    return;
  }
  yaw_.start(Number::template number<Real>(wrapped_yaw(pose)));
  attitude_.yaw_rad = Number::template real<Real>(yaw_.yaw());
  const core::Tilt<Real> tilt = core::tilt_of(attitude_);
  const core::Vector<Real, 3> velocity = velocity_since_first(pose, tilt.x_rad, tilt.y_rad);
  const Real age_units = core::seconds<Real>(pose.age(now_)) / static_cast<Real>(kTimeUnit_s);
  const core::Vector<Real, 3> position = pose.position_w_m + velocity * age_units;
  x_.start(Number::template number<Real>(position.x()), Number::template number<Real>(velocity.x()),
           Number::template number<Real>(tilt.x_rad));
  y_.start(Number::template number<Real>(position.y()), Number::template number<Real>(velocity.y()),
           Number::template number<Real>(tilt.y_rad));
  height_.start(Number::template number<Real>(position.z()), Number::template number<Real>(velocity.z()));
  started_ = true;
  since_start_ = core::Duration(0);
  since_pose_ = core::Duration(0);
  ceilings_at_pose_ = ceilings_met();
  pose_age_ = pose.age(now_);
  agreeing_ = 0;
  ++counters_.poses_used;
}

template <typename S, typename Real>
bool DisturbanceEkf<S, Real>::agrees(const core::Pose<Real>& pose) {
  const double between_s = core::seconds<double>(since_last_ - pose.age(now_));
  const Real way_m = static_cast<Real>(kAgreement_m + kFastestFlight_m_s * (between_s > 0.0 ? between_s : 0.0));
  const core::Vector<Real, 3> moved = pose.position_w_m - last_pose_.position_w_m;
  const bool follows = agreeing_ > 0 && moved.squaredNorm() <= way_m * way_m;
  agreeing_ = follows ? agreeing_ + 1 : 1;
  last_pose_ = pose;
  agreeing_until_ = now_;
  since_last_ = pose.age(now_);
  if (!follows) {
    first_pose_ = pose;
    agreeing_since_ = now_;
    since_first_ = pose.age(now_);
  }
  return follows;
}

template <typename S, typename Real>
void DisturbanceEkf<S, Real>::check_reset(const core::Pose<Real>& pose, const MeasurementAge<S>& age) {
  using Number = core::Arithmetic<S>;
  const bool follows = agrees(pose);
  const core::Duration agreeing_for = since_first_ - pose.age(now_);
  const bool dropped_out = since_pose_ > kDropout + agreeing_for;
  const std::uint32_t needed = dropped_out ? kAgreeingAfterDropout : kAgreeingPoses;
  if (!follows || agreeing_ < needed || agreeing_for < (dropped_out ? kBaseline : kAgreeingFor) ||
      (!dropped_out && since_recovery_ < kResetSpacing)) {
    return;
  }
  recover(dropped_out ? ResetReason::kLongDropout : ResetReason::kPoseMoved);
  using Filter = AxisFilter<S>;
  const core::Vector<Real, 3> velocity = velocity_since_first(
      pose, Number::template real<Real>(x_.state(Filter::kTilt)), Number::template real<Real>(y_.state(Filter::kTilt)));
  const auto number = [](Real value) { return Number::template number<Real>(value); };
  x_.reset_position(number(pose.position_w_m.x()), number(velocity.x()), age);
  y_.reset_position(number(pose.position_w_m.y()), number(velocity.y()), age);
  height_.reset_position(number(pose.position_w_m.z()), number(velocity.z()), age);
  yaw_.reset_position(number(wrapped_yaw(pose)));
  refused_in_a_row_ = 0;
  agreeing_ = 0;
  since_pose_ = core::Duration(0);
  ceilings_at_pose_ = ceilings_met();
  pose_age_ = pose.age(now_);
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
  attitude_known_ = false;
  attitudes_refused_in_a_row_ = 0;
  refused_in_a_row_ = 0;
  agreeing_ = 0;
  x_.start(S{}, S{}, S{});
  y_.start(S{}, S{}, S{});
  height_.start(S{}, S{});
  yaw_.start(S{});
  gyro_yaw_rate_ = S{};
}

#define M100_INSTANTIATE(S, Real)                                                                        \
  template bool DisturbanceEkf<S, Real>::agrees(const core::Pose<Real>&);                                \
  template void DisturbanceEkf<S, Real>::begin(const core::Pose<Real>&);                                 \
  template void DisturbanceEkf<S, Real>::check_reset(const core::Pose<Real>&, const MeasurementAge<S>&); \
  template void DisturbanceEkf<S, Real>::recover(ResetReason);                                           \
  template void DisturbanceEkf<S, Real>::restart();
M100_INSTANTIATE(double, double)
M100_INSTANTIATE(float, float)
M100_INSTANTIATE(core::Fixed, float)
#undef M100_INSTANTIATE

}  // namespace m100::est
