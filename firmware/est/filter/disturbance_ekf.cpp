// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/filter/disturbance_ekf.h"

#include <array>

#include "firmware/core/assert.h"
#include "firmware/core/maths.h"
#include "firmware/core/tilt.h"

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
constexpr core::Duration kDropout = milliseconds(500);
constexpr core::Duration kPoseLost = milliseconds(1000);  // then the prediction is abandoned

/// A heading that turned alone is never confirmed.
constexpr double kYawGate_rad = 0.35;
static_assert(kYawGate_rad >= 2.0 * HeadingVote<double>::kAgrees_rad);
constexpr core::Duration kConfirmedFor = milliseconds(300);
constexpr double kUnseenAcceleration_m_s2 = 3.0;  // largest change of the acceleration by wind while no pose comes
constexpr double kDisturbanceLag_s = 0.15;  // time constant with which the observer learns a disturbance from poses
constexpr core::Duration kResetSpacing = milliseconds(2000);

core::Duration older(core::Duration age, core::Duration by) { return age > kLongest ? age : age + by; }

/// Whether |value| <= limit; false for NaN.
template <typename Real>
bool inside(Real value, double limit) {
  return value <= static_cast<Real>(limit) && value >= static_cast<Real>(-limit);
}

template <typename S, typename Real>
S age_of(core::Duration age) {
  return S(core::clamp(core::seconds<Real>(age), Real(0), static_cast<Real>(kMaxPoseAge_s)));
}

template <typename Real>
Real wrapped_yaw(const core::Pose<Real>& pose) {
  return core::wrap_pi(core::clamp(pose.yaw_rad, Real(-100), Real(100)));
}

}  // namespace

std::string_view name(ResetReason recovery) {
  constexpr std::array<std::string_view, 5> kNames{"none", "the pose source moved the vehicle",
                                                   "no pose for more than 0.5 s", "attitudes refused for 0.5 s",
                                                   "a state was not a number"};
  const auto number = static_cast<std::size_t>(recovery);
  return number < kNames.size() ? kNames[number] : "unknown";
}

template <typename S, typename Real>
[[gnu::cold]] DisturbanceEkf<S, Real>::DisturbanceEkf(const model::Vehicle& vehicle, Tilts tilts)
    : x_(AxisModel::of(vehicle, tilts == Tilts::kIdentified ? vehicle.pitch : model::flown_pitch(vehicle), 1.0)),
      y_(AxisModel::of(vehicle, tilts == Tilts::kIdentified ? vehicle.roll : model::flown_roll(vehicle), -1.0)),
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
    counters_.not_finite += commands_.store(applied_command, heading_.of(static_cast<Real>(yaw_.yaw()))) ? 0U : 1U;
    predict_tick();
  }
  for (core::Duration* age : {&since_start_, &attitude_.age, &pose_.since_use, &pose_.age, &since_recovery_,
                              &agreement_.since_last(), &agreement_.since_first()}) {
    *age = older(*age, elapsed);
  }
  if (attitude_.age > kAttitudeDoubted) {
    attitude_.yaw_rate_rad_s = Real(0);  // without attitudes a turn is not assumed to go on
  }
  if (measured.attitude.is_new) {
    fuse_attitude(measured.attitude);
  }
  if (measured.pose.is_new && time_.behind() <= core::kTickPeriod) {
    fuse_pose(measured.pose);
  }
  fuse_specific_force(measured.disturbance_acceleration);
  if (started_ && !(x_.is_sane() && y_.is_sane() && height_.is_sane() && yaw_.is_sane())) {
    recover(ResetReason::kNotFinite);
    restart();
  }
  (void)heading_.of(static_cast<Real>(yaw_.yaw()));  // once for all users of the estimate
  update_estimate();
  return estimate_;
}

template <typename S, typename Real>
void DisturbanceEkf<S, Real>::predict_tick() {
  yaw_.predict(S(attitude_.yaw_rate_rad_s));
  if (!started_) {
    return;
  }
  x_.predict(commands_.x().template as<S>());
  y_.predict(commands_.y().template as<S>());
  height_.predict(commands_.climb().template as<S>());
}

template <typename S, typename Real>
void DisturbanceEkf<S, Real>::fuse_attitude(const typename Measurement<Real>::Attitude& attitude) {
  const core::Vector<Real, 3>& rate = attitude.rate_b_rad_s;
  attitude_.is_refused = true;
  if (!core::Vector<Real, 2>(attitude.roll_rad, attitude.pitch_rad).allFinite() || !rate.allFinite()) {
    ++counters_.not_finite;
    return;
  }
  if (!inside(attitude.roll_rad, kLargestAttitude_rad) || !inside(attitude.pitch_rad, kLargestAttitude_rad) ||
      !inside(rate.cwiseAbs().maxCoeff(), 20.0)) {
    ++counters_.attitudes_refused;
    return;
  }
  attitude_.angles = {
      .roll_rad = attitude.roll_rad, .pitch_rad = attitude.pitch_rad, .yaw_rad = static_cast<Real>(yaw_.yaw())};
  const core::AttitudeSinCos<Real> turns{
      .roll = attitude.roll(), .pitch = attitude.pitch(), .yaw = heading_.of(attitude_.angles.yaw_rad)};
  attitude_.yaw_rate_rad_s = attitude_.vote.turn_rate(attitude.yaw_rad, core::yaw_rate_of(turns, rate), started_, now_);
  attitude_.is_known = true;
  if (!started_) {
    attitude_.is_refused = false;
    attitude_.age = attitude.age;
    return;
  }
  const core::Tilt<Real> tilt = core::tilt_of(core::slope_of(turns));
  const core::Tilt<Real> tilt_rate = core::tilt_rate_of(turns, rate);
  const S age_s = age_of<S, Real>(attitude.age);
  const FusionResult x = x_.fuse_attitude(S(tilt.x_rad), S(tilt_rate.x_rad), age_s);
  const FusionResult y = y_.fuse_attitude(S(tilt.y_rad), S(tilt_rate.y_rad), age_s);
  if (x == FusionResult::kUsed && y == FusionResult::kUsed) {
    attitude_.refused_in_a_row = 0;
    attitude_.is_refused = false;
    attitude_.age = attitude.age;
    attitude_.tilt = tilt;
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
  const auto limited = [](Real m_s2) { return S(core::clamp(m_s2, Real(-20), Real(20))); };
  x_.fuse_specific_force(limited(disturbance_acceleration.mean_w_m_s2.x()), use);
  y_.fuse_specific_force(limited(disturbance_acceleration.mean_w_m_s2.y()), use);
  pose_.acceleration_stored = true;
}

template <typename S, typename Real>
void DisturbanceEkf<S, Real>::record_used(const core::Pose<Real>& pose, bool heading_used) {
  pose_.refused_in_a_row = 0;
  if (heading_used) {
    attitude_.vote.use_pose();
  }
  agreement_.end_row();
  pose_.since_use = core::Duration(0);
  pose_.age = pose.age(now_);
  pose_.time_sigma_s = pose.time_sigma_s;
}

template <typename S, typename Real>
bool DisturbanceEkf<S, Real>::accepts_heading(Real turned_rad, bool follows) {
  if (!follows || pose_.refused_in_a_row == 0) {
    pose_.turned_since = now_;
  }
  if (!follows || inside(turned_rad, kYawGate_rad)) {
    return follows;
  }
  return pose_.heading_reset == HeadingReset::kConfirmed && now_ - pose_.turned_since >= kConfirmedFor &&
         attitude_.vote.confirms_pose();
}

template <typename S, typename Real>
void DisturbanceEkf<S, Real>::correct(AxisFilter<S>& filter, CovarianceInflation<Real>& lag,
                                      const PoseInnovation<S>& test) {
  using Filter = AxisFilter<S>;
  const Real position_m = static_cast<Real>(filter.state(Filter::kP));
  const Real velocity_m_s = static_cast<Real>(filter.state(Filter::kV));
  filter.fuse_pose(test);
  lag.update(static_cast<Real>(test.innovation_m), static_cast<Real>(filter.state(Filter::kP)) - position_m,
             static_cast<Real>(filter.state(Filter::kV)) - velocity_m_s, test.template normalised_square<Real>(),
             core::seconds<Real>(pose_.since_use));
}

template <typename S, typename Real>
void DisturbanceEkf<S, Real>::fuse_pose(const core::Pose<Real>& pose) {
  if (!pose.position_w_m.allFinite() || !(pose.yaw_rad - pose.yaw_rad == Real(0))) {
    ++counters_.not_finite;
    return;
  }
  const Real capture_age_s = core::seconds<Real>(pose.age(now_));
  if (capture_age_s > static_cast<Real>(kMaxPoseAge_s) || capture_age_s < Real(0)) {
    ++counters_.poses_stale;
    return;
  }
  attitude_.vote.see_pose(wrapped_yaw(pose));
  if (!started_) {
    return begin(pose);
  }
  // Once the prediction is abandoned, every pose goes to check_reset(): weighted with the sigmas of a second without
  // poses, one pose would set the velocity.
  if (pose_.since_use > kPoseLost) {
    return check_reset(pose);
  }
  const Real dropout_s = core::seconds<Real>(pose_.since_use);
  constexpr Real kHalf_m_s2 = static_cast<Real>(0.5 * kUnseenAcceleration_m_s2);
  const bool long_dropout = pose_.since_use > kDropout;  // then the gate is the sigmas alone
  const Real unseen_m = kHalf_m_s2 * (dropout_s * dropout_s + static_cast<Real>(kDisturbanceLag_s * kDisturbanceLag_s));
  Real widest_m(0);
  const S age_s = age_of<S, Real>(pose.age(now_));
  const auto test = [&](const auto& filter, Eigen::Index axis, S speed_m_s, Real lag_m) {
    const Real sender_m2 = pose.position_variance_m2[axis];
    const PoseWeight<Real> by =
        weight_of(sender_m2 > pose_variance_m2_ ? sender_m2 : pose_variance_m2_,
                  static_cast<Real>(speed_m_s) * pose.time_sigma_s, long_dropout ? Real(0) : unseen_m + lag_m);
    widest_m = by.unseen_m > widest_m ? by.unseen_m : widest_m;
    return filter.test_pose(S(pose.position_w_m[axis]), age_s, S(by.unseen_m), S(by.variance_m2));
  };
  const PoseInnovation<S> x = test(x_, 0, x_.state(AxisFilter<S>::kV), lag_m(inflation_x_, dropout_s));
  const PoseInnovation<S> y = test(y_, 1, y_.state(AxisFilter<S>::kV), lag_m(inflation_y_, dropout_s));
  const PoseInnovation<S> z = test(height_, 2, height_.state(HeightFilter<S>::kClimb), Real(0));
  const S turned_rad = yaw_.innovation(S(wrapped_yaw(pose)), age_s);
  if (!accepts_heading(static_cast<Real>(turned_rad), x.inside && y.inside && z.inside)) {
    ++counters_.poses_refused;
    ++pose_.refused_in_a_row;
    pose_.refusal = refusal_of(static_cast<Real>(turned_rad), widest_m, {x, y, z});
    return check_reset(pose);
  }
  counters_.nis_sum += x.template normalised_square<float>() + y.template normalised_square<float>();
  correct(x_, inflation_x_, x);
  correct(y_, inflation_y_, y);
  height_.fuse_pose(z);
  inside(static_cast<Real>(turned_rad), kYawGate_rad) ? yaw_.correct(turned_rad, age_s)
                                                      : yaw_.reset_yaw(S(wrapped_yaw(pose)));
  ++counters_.poses_used;
  record_used(pose, true);
}

template <typename S, typename Real>
[[gnu::cold]] void DisturbanceEkf<S, Real>::set_motion(const core::Pose<Real>& pose, bool with_heading) {
  using Filter = AxisFilter<S>;
  const core::Vector<Real, 3> velocity_m_s = agreement_.velocity(pose, now_, static_cast<Real>(x_.state(Filter::kTilt)),
                                                                 static_cast<Real>(y_.state(Filter::kTilt)));
  const auto set = [&](auto& filter, Eigen::Index axis) {
    filter.reset_position(S(pose.position_w_m[axis]), S(velocity_m_s[axis]), age_of<S, Real>(pose.age(now_)),
                          agreement_.variance(pose, now_, axis));
  };
  set(x_, 0);
  set(y_, 1);
  set(height_, 2);
  if (with_heading) {
    yaw_.reset_yaw(S(wrapped_yaw(pose)));
  }
  record_used(pose, with_heading);
}

template <typename S, typename Real>
[[gnu::cold]] void DisturbanceEkf<S, Real>::begin(const core::Pose<Real>& pose) {
  if (!attitude_.is_known || !agreement_.add(pose, now_) || !agreement_.gives_velocity(pose, now_)) {
    return;
  }
  yaw_.start(S(wrapped_yaw(pose)));
  attitude_.angles.yaw_rad = static_cast<Real>(yaw_.yaw());
  const core::Tilt<Real> tilt = core::tilt_of(attitude_.angles);
  x_.start(S(tilt.x_rad));
  y_.start(S(tilt.y_rad));
  height_.start();
  set_motion(pose, true);
  attitude_.vote.begin();
  started_ = true;
  since_start_ = core::Duration(0);
  ++counters_.poses_used;
}

template <typename S, typename Real>
[[gnu::cold]] void DisturbanceEkf<S, Real>::check_reset(const core::Pose<Real>& pose) {
  const bool follows = agreement_.add(pose, now_);
  const bool dropped_out = pose_.since_use > kDropout + agreement_.span(pose, now_);
  if (!follows || !agreement_.is_confirmed(pose, now_, dropped_out) ||
      (!dropped_out && since_recovery_ < kResetSpacing)) {
    return;
  }
  recover(dropped_out ? ResetReason::kLongDropout : ResetReason::kPoseMoved);
  set_motion(pose, pose_.heading_reset == HeadingReset::kFree);
}

template <typename S, typename Real>
void DisturbanceEkf<S, Real>::recover(ResetReason reason) {
  ++counters_.recoveries;
  counters_.last_recovery = reason;
  since_recovery_ = core::Duration(0);
}

template <typename S, typename Real>
[[gnu::cold]] void DisturbanceEkf<S, Real>::restart() {
  started_ = false;
  attitude_.is_known = false;
  attitude_.refused_in_a_row = 0;
  pose_.refused_in_a_row = 0;
  agreement_.end_row();
  x_.start(S(0));
  y_.start(S(0));
  height_.start();
  yaw_.start(S(0));
  attitude_.yaw_rate_rad_s = Real(0);
}

template <typename S, typename Real>
AxisEstimate<Real> DisturbanceEkf<S, Real>::estimate_of(const AxisFilter<S>& f, const CovarianceInflation<Real>& lag,
                                                        Real measured_tilt_rad) const {
  using Filter = AxisFilter<S>;
  const auto state = [&f](typename Filter::StateIndex i) { return static_cast<Real>(f.state(i)); };
  const auto covariance = [&f](int row, int col) { return static_cast<Real>(f.covariance(row, col)); };
  // A time of capture that is wrong by dt makes the position wrong by velocity dt, the velocity by acceleration dt.
  const Real way_m = state(Filter::kV) * pose_.time_sigma_s;
  const Real speed_change_m_s = static_cast<Real>(model::kGravity_m_s2) * state(Filter::kTilt) * pose_.time_sigma_s;
  const Real own_m2 = covariance(Filter::kP, Filter::kP);
  const typename CovarianceInflation<Real>::Covariance inflated = lag.inflated(
      {.pp_m2 = own_m2, .pv_m2_s = covariance(Filter::kV, Filter::kP), .vv_m2_s2 = covariance(Filter::kV, Filter::kV)},
      core::seconds<Real>(pose_.age), core::seconds<Real>(pose_.since_use), pose_.acceleration_stored);
  return {.position_m = state(Filter::kP),
          .velocity_m_s = state(Filter::kV),
          .tilt_rad = state(Filter::kTilt),
          .tilt_rate_rad_s = state(Filter::kRate),
          .disturbance_m_s2 = state(Filter::kD),
          .input_offset_rad = state(Filter::kM),
          .position_variance_m2 = inflated.pp_m2 + way_m * way_m,
          .filter_variance_m2 = own_m2 + way_m * way_m,
          .position_velocity_m2_s = inflated.pv_m2_s,
          .velocity_variance_m2_s2 = inflated.vv_m2_s2 + speed_change_m_s * speed_change_m_s,
          .measured_tilt_rad = measured_tilt_rad};
}

template <typename S, typename Real>
void DisturbanceEkf<S, Real>::update_estimate() {
  Estimate<Real>& e = estimate_;
  e.x = estimate_of(x_, inflation_x_, attitude_.tilt.x_rad);
  e.y = estimate_of(y_, inflation_y_, attitude_.tilt.y_rad);
  e.height_m = static_cast<Real>(height_.state(HeightFilter<S>::kZ));
  e.climb_m_s = static_cast<Real>(height_.state(HeightFilter<S>::kClimb));
  e.climb_offset_m_s = static_cast<Real>(height_.state(HeightFilter<S>::kOffset));
  e.pose_height_variance_m2 = static_cast<Real>(height_.pose_height_variance());
  e.height_gain = static_cast<Real>(height_.gain());
  e.climb_gain_per_s = static_cast<Real>(height_.climb_gain());
  e.yaw_rad = static_cast<Real>(yaw_.yaw());
  e.heading_sin_cos = heading_;
  e.yaw_rate_rad_s = static_cast<Real>(yaw_.yaw_rate());
  e.pose_age = pose_.age;
  e.refused_poses = pose_.refused_in_a_row;
  e.refused_for = pose_.refused_in_a_row > 0 ? agreement_.lasted() : core::Duration{0};
  e.refusal = pose_.refusal;
  e.attitude_is_known = attitude_.age <= (attitude_.is_refused ? kAttitudeDoubted : kAttitudeSilent);
  e.prediction_valid = started_ && since_start_ >= kSettling && e.attitude_is_known;
  e.healthy = e.prediction_valid && pose_.since_use <= kPoseLost;
}

template class DisturbanceEkf<double, double>;
template class DisturbanceEkf<float, float>;
template class DisturbanceEkf<core::Fixed, float>;

}  // namespace m100::est
