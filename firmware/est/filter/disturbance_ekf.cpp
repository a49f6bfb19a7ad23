// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/filter/disturbance_ekf.h"

#include "firmware/core/assert.h"
#include "firmware/core/maths.h"
#include "firmware/core/tilt.h"
#include "firmware/est/filter/reset_pose.h"
#include "firmware/est/filter/units.h"

namespace m100::est {
namespace {

using std::chrono::milliseconds;

constexpr std::uint32_t kAttitudesBeforeRestart = 50;
constexpr core::Duration kSettling = milliseconds(500);
constexpr core::Duration kPoseMissed = milliseconds(100);  // longer than the usual pauses of a source
constexpr core::Duration kAttitudeDoubted = milliseconds(100);
// Up to this age of the attitude the estimate stays valid: the model predicts the tilt from the commands (COAST). It is
// shorter than Limits::telemetry_dead.
constexpr core::Duration kAttitudeSilent = milliseconds(450);
constexpr core::Duration kLongest = std::chrono::hours(1);

core::Duration older(core::Duration age, core::Duration by) { return age > kLongest ? age : age + by; }

CovarianceHealth operator+(const CovarianceHealth& a, const CovarianceHealth& b) {
  return {a.floors + b.floors, a.ceilings + b.ceilings, a.repairs + b.repairs, a.saturations + b.saturations};
}

}  // namespace

std::string_view name(ResetReason recovery) {
  switch (recovery) {
    case ResetReason::kNone:
      return "none";
    case ResetReason::kPoseMoved:
      return "the pose source moved the vehicle";
    case ResetReason::kLongDropout:
      return "no pose for more than 0.5 s";
    case ResetReason::kAttitude:
      return "attitudes refused for 0.5 s";
    case ResetReason::kNotFinite:
      return "a state was not a number";
  }
  return "unknown";
}

template <typename S, typename Real>
AxisModel DisturbanceEkf<S, Real>::axis_model(const model::Vehicle& vehicle, const model::StickAxis& axis,
                                              double sign) {
  return {.attitude = axis,
          .tilt_sign = sign,
          .tilt_gain = vehicle.translation.tilt_gain,
          .linear_drag_per_s = vehicle.translation.linear_drag_per_s,
          .quadratic_drag_per_m = vehicle.translation.quadratic_drag_per_m,
          .noise = model::flown_noise(vehicle)};
}

template <typename S, typename Real>
[[gnu::cold]] DisturbanceEkf<S, Real>::DisturbanceEkf(const model::Vehicle& vehicle)
    : x_(axis_model(vehicle, model::flown_pitch(vehicle), 1.0)),
      y_(axis_model(vehicle, model::flown_roll(vehicle), -1.0)),
      height_(vehicle.climb, model::flown_noise(vehicle).pose_position_sigma_m),
      yaw_(model::flown_noise(vehicle).attitude_sigma_rad),
      commands_(vehicle),
      pose_variance_m2_(static_cast<Real>(model::flown_noise(vehicle).pose_position_sigma_m *
                                          model::flown_noise(vehicle).pose_position_sigma_m)) {}

template <typename S, typename Real>
const Estimate<Real>& DisturbanceEkf<S, Real>::update(const Measurement<Real>& measured,
                                                      const ctl::Command<Real>& applied_command, core::Duration elapsed,
                                                      HeadingReset heading_reset) {
  M100_ASSERT(elapsed >= core::Duration(0));
  now_ = measured.now;
  pose_.heading_reset = heading_reset;
  for (int ticks = time_.take(elapsed, kMaxTicks); ticks > 0; --ticks) {
    counters_.not_finite +=
        commands_.store(applied_command, heading_.of(core::Arithmetic<S>::template real<Real>(yaw_.yaw()))) ? 0U : 1U;
    predict_tick();
  }
  for (core::Duration* age : {&since_start_, &attitude_.age, &pose_.since_use, &pose_.age, &since_recovery_,
                              &agreement_.since_last(), &agreement_.since_first()}) {
    *age = older(*age, elapsed);
  }
  if (attitude_.age > kAttitudeDoubted) {
    attitude_.yaw_rate = S{};  // without attitudes a turn is not assumed to go on
  }
  if (measured.attitude.is_new) {
    attitude_.is_refused = true;
    fuse_attitude(measured.attitude);
  }
  if (measured.pose.is_new && time_.behind() <= core::kTickPeriod) {
    fuse_pose(measured.pose);
  }
  if (measured.attitude.is_new || measured.pose.is_new) {
    x_.check();
    y_.check();
  }
  fuse_specific_force(measured.disturbance_acceleration);
  if (started_ && !(x_.is_sane() && y_.is_sane() && height_.is_sane() && yaw_.is_sane())) {
    recover(ResetReason::kNotFinite);
    restart();
  }
  (void)heading_.of(core::Arithmetic<S>::template real<Real>(yaw_.yaw()));  // once for all users of the estimate
  update_estimate();
  return estimate_;
}

template <typename S, typename Real>
void DisturbanceEkf<S, Real>::predict_tick() {
  yaw_.predict(attitude_.yaw_rate);
  if (!started_) {
    return;
  }
  x_.predict(commands_.x());
  y_.predict(commands_.y());
  height_.predict(commands_.climb());
}

template <typename S, typename Real>
void DisturbanceEkf<S, Real>::fuse_attitude(const typename Measurement<Real>::Attitude& attitude) {
  using Number = core::Arithmetic<S>;
  const core::Vector<Real, 3>& rate = attitude.rate_b_rad_s;
  if (!finite(attitude.roll_rad) || !finite(attitude.pitch_rad) || !finite(rate.x()) || !finite(rate.y()) ||
      !finite(rate.z())) {
    ++counters_.not_finite;
    return;
  }
  const auto beyond = [](Real value, double limit) { return value > Real(limit) || value < Real(-limit); };
  if (beyond(attitude.roll_rad, kLargestAttitude_rad) || beyond(attitude.pitch_rad, kLargestAttitude_rad) ||
      beyond(rate.x(), 20.0) || beyond(rate.y(), 20.0) || beyond(rate.z(), 20.0)) {
    ++counters_.attitudes_refused;
    return;
  }
  attitude_.angles = {.roll_rad = attitude.roll_rad,
                      .pitch_rad = attitude.pitch_rad,
                      .yaw_rad = Number::template real<Real>(yaw_.yaw())};
  attitude_.reported_yaw_rad = attitude.yaw_rad;
  constexpr Real kUnit = static_cast<Real>(kTimeUnit_s);
  const core::AttitudeSinCos<Real> turns{
      .roll = attitude.roll(), .pitch = attitude.pitch(), .yaw = heading_.of(attitude_.angles.yaw_rad)};
  attitude_.yaw_rate = Number::template number<Real>(core::yaw_rate_of(turns, rate) * kUnit);
  attitude_.is_known = true;
  if (!started_) {
    attitude_.is_refused = false;
    attitude_.age = attitude.age;
    return;
  }
  const core::Tilt<Real> tilt = core::tilt_of(core::slope_of(turns));
  const core::Tilt<Real> tilt_rate = core::tilt_rate_of(turns, rate);
  const MeasurementAge<S> age = MeasurementAge<S>::of(core::seconds<Real>(attitude.age));
  const FusionResult x = x_.fuse_attitude(Number::template number<Real>(tilt.x_rad),
                                          Number::template number<Real>(tilt_rate.x_rad * kUnit), age);
  const FusionResult y = y_.fuse_attitude(Number::template number<Real>(tilt.y_rad),
                                          Number::template number<Real>(tilt_rate.y_rad * kUnit), age);
  if (x == FusionResult::kUsed && y == FusionResult::kUsed) {
    attitude_.refused_in_a_row = 0;
    attitude_.is_refused = false;
    attitude_.age = attitude.age;
    return;
  }
  ++counters_.attitudes_refused;
  if (++attitude_.refused_in_a_row >= kAttitudesBeforeRestart && since_recovery_ >= kResetSpacing) {
    recover(ResetReason::kAttitude);
    restart();
  }
}

template <typename S, typename Real>
void DisturbanceEkf<S, Real>::fuse_specific_force(const DisturbanceAcceleration<Real>& disturbance_acceleration) {
  using DisturbanceUse = typename AxisFilter<S>::DisturbanceUse;
  if (!disturbance_acceleration.is_known) {
    pose_.acceleration_stored = false;
    return;
  }
  const bool missed = pose_.since_use > kPoseMissed;
  const bool notes = !pose_.acceleration_stored || pose_.since_use == core::Duration(0);
  const DisturbanceUse use = notes    ? DisturbanceUse::kStored
                             : missed ? DisturbanceUse::kTracked
                                      : DisturbanceUse::kHeld;
  constexpr Real kUnits = static_cast<Real>(kTimeUnit_s * kTimeUnit_s);
  const auto limit = static_cast<Real>(20.0) * kUnits;
  const auto number = [=](Real m_s2) {
    return core::Arithmetic<S>::template number<Real>(core::clamp(m_s2 * kUnits, -limit, limit));
  };
  x_.fuse_specific_force(number(disturbance_acceleration.mean_w_m_s2.x()), use);
  y_.fuse_specific_force(number(disturbance_acceleration.mean_w_m_s2.y()), use);
  pose_.acceleration_stored = true;
}

template <typename S, typename Real>
void DisturbanceEkf<S, Real>::update_estimate() {
  constexpr Real kPerUnit = static_cast<Real>(1.0 / kTimeUnit_s);
  const auto real = [](S value) { return core::Arithmetic<S>::template real<Real>(value); };
  Estimate<Real>& e = estimate_;
  e.x = estimate_of(x_, inflation_x_);
  e.y = estimate_of(y_, inflation_y_);
  e.height_m = real(height_.state(HeightFilter<S>::kZ));
  e.climb_m_s = real(height_.state(HeightFilter<S>::kClimb)) * kPerUnit;
  e.climb_offset_m_s = real(height_.state(HeightFilter<S>::kOffset)) * kPerUnit;
  e.pose_height_variance_m2 =
      real(height_.scaled_pose_height_variance()) * power_of_two<Real>(2 * HeightFilter<S>::kHeightScale);
  e.height_gain = real(height_.gain());
  e.climb_gain_per_s = real(height_.climb_gain()) * kPerUnit;
  e.yaw_rad = real(yaw_.yaw());
  e.heading_sin_cos = heading_;
  e.yaw_rate_rad_s = real(yaw_.yaw_rate()) * kPerUnit;
  e.pose_age = pose_.age;
  e.refused_poses = pose_.refused_in_a_row;
  e.refused_for = pose_.refused_in_a_row > 0 ? agreement_.lasted() : core::Duration{0};
  e.refusal = pose_.refusal;
  e.attitude_is_known = attitude_.age <= (attitude_.is_refused ? kAttitudeDoubted : kAttitudeSilent);
  e.prediction_valid = started_ && since_start_ >= kSettling && e.attitude_is_known;
  e.healthy = e.prediction_valid && pose_.since_use <= kPoseLost;
}

template <typename S, typename Real>
EkfCounters DisturbanceEkf<S, Real>::counters() const {
  EkfCounters counters = counters_;
  counters.covariance = x_.health() + y_.health() + height_.health() + yaw_.health();
  counters.covariance.saturations += commands_.saturations();
  return counters;
}

template class DisturbanceEkf<double, double>;
template class DisturbanceEkf<float, float>;
template class DisturbanceEkf<core::Fixed, float>;

}  // namespace m100::est
