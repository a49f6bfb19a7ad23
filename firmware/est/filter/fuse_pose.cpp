// SPDX-License-Identifier: BSD-3-Clause
// Measurement variance of a pose, its innovation gate, and its correction of the state.
#include <type_traits>

#include "firmware/core/maths.h"
#include "firmware/est/filter/disturbance_ekf.h"
#include "firmware/est/filter/reset_pose.h"
#include "firmware/est/filter/units.h"

namespace m100::est {
namespace {

constexpr double kYawGate_rad = 0.35;
/// A turn is confirmed if the autopilot's heading and the pose's differ by less: 0.1 s of a wrong time of capture at
/// the largest yaw rate, 100 deg/s. It is half the gate, so a heading that turned alone is never confirmed.
constexpr double kYawConfirmed_rad = 0.5 * kYawGate_rad;
constexpr core::Duration kConfirmedFor = std::chrono::milliseconds(300);
constexpr double kUnseenAcceleration_m_s2 = 3.0;  // largest change of the acceleration by wind while no pose comes
constexpr double kDisturbanceLag_s = 0.15;  // time constant with which the observer learns a disturbance from poses
/// Largest pose error by speed times uncertainty of the latency that the filter's variance includes. With a larger one
/// the sigma of the position could meet its ceiling, and the covariance would lose its correlations.
constexpr double kMaxTimingError_m = 0.03;

/// Distance that the gate allows for the lag of the estimated disturbance: six sigmas of the position error that
/// CovarianceInflation adds, at most 0.5 m.
template <typename Real>
Real lag_m(const CovarianceInflation<Real>& inflation, Real since_s) {
  const Real variance_m2 = inflation.inflated({}, since_s, since_s).pp_m2;
  return core::clamp(static_cast<Real>(kGateSigmas) * core::sqrt(variance_m2), Real(0),
                     static_cast<Real>(0.5 * kLargestInnovation_m));
}

/// The refusal of a pose, on the axis with the largest ratio of distance to gate.
template <typename Real, typename... Tests>
Refusal<Real> refusal_of(Real turned_rad, Real unseen_m, const Tests&... tests) {
  Refusal<Real> worst{.turned_rad = turned_rad < Real(0) ? -turned_rad : turned_rad};
  const auto look = [&](const auto& test) {
    using S = std::remove_cvref_t<decltype(test.innovation)>;
    const Real innovation_m = core::Arithmetic<S>::template real<Real>(test.innovation);
    const Real distance_m = innovation_m < Real(0) ? -innovation_m : innovation_m;
    const Real allowed_m = gate_m<Real>(test.projection.s, test.noise, test.scale, unseen_m);
    if (distance_m * worst.allowed_m >= worst.distance_m * allowed_m) {
      worst.distance_m = distance_m;
      worst.allowed_m = allowed_m;
    }
  };
  (look(tests), ...);
  return worst;
}

}  // namespace

template <typename S, typename Real>
typename DisturbanceEkf<S, Real>::Weight DisturbanceEkf<S, Real>::weight(Real sender_variance_m2, Real time_sigma_s,
                                                                         S speed, Real unseen_m) const {
  using Number = core::Arithmetic<S>;
  constexpr Real kMax_m = static_cast<Real>(kMaxTimingError_m);
  const Real way_m = Number::template real<Real>(speed) * static_cast<Real>(1.0 / kTimeUnit_s) * time_sigma_s;
  const Real way_m2 = way_m * way_m;
  const Real claimed_m2 = sender_variance_m2 > pose_variance_m2_ ? sender_variance_m2 : pose_variance_m2_;
  if (way_m2 <= kMax_m * kMax_m) {
    return {.variance_m2 = static_cast<float>(claimed_m2 + way_m2),
            .unseen_m = Number::template number<Real>(unseen_m)};
  }
  const Real gate_m = core::clamp(static_cast<Real>(kGateSigmas) * core::sqrt(claimed_m2 + way_m2), unseen_m,
                                  static_cast<Real>(kLargestInnovation_m));
  return {.variance_m2 = static_cast<float>(claimed_m2 + kMax_m * kMax_m),
          .unseen_m = Number::template number<Real>(gate_m)};
}

template <typename S, typename Real>
void DisturbanceEkf<S, Real>::record_used(const core::Pose<Real>& pose, bool heading_used) {
  pose_.refused_in_a_row = 0;
  pose_.heading_offset_rad = heading_used ? heading_offset_rad() : pose_.heading_offset_rad;
  agreement_.end_row();
  pose_.since_use = core::Duration(0);
  pose_.age = pose.age(now_);
  pose_.time_sigma_s = pose.time_sigma_s;
}

template <typename S, typename Real>
Real DisturbanceEkf<S, Real>::heading_offset_rad() const {
  return core::wrap_pi(core::Arithmetic<S>::template real<Real>(yaw_.yaw()) - attitude_.reported_yaw_rad);
}

template <typename S, typename Real>
bool DisturbanceEkf<S, Real>::accepts_heading(S turned, bool follows) {
  if (!follows || pose_.refused_in_a_row == 0) {
    pose_.turned_since = now_;
  }
  if (!follows || inside(turned, kYawGate_rad)) {
    return follows;
  }
  const Real unseen_rad =
      pose_.heading_offset_rad - heading_offset_rad();  // the autopilot turned, the estimate did not
  const Real apart_rad = core::wrap_pi(core::wrap_pi(unseen_rad) - core::Arithmetic<S>::template real<Real>(turned));
  return pose_.heading_reset == HeadingReset::kConfirmed && now_ - pose_.turned_since >= kConfirmedFor &&
         inside(apart_rad, kYawConfirmed_rad);
}

template <typename S, typename Real>
void DisturbanceEkf<S, Real>::fuse_pose(const core::Pose<Real>& pose) {
  using Number = core::Arithmetic<S>;
  if (!finite(pose.position_w_m.x()) || !finite(pose.position_w_m.y()) || !finite(pose.position_w_m.z()) ||
      !finite(pose.yaw_rad)) {
    ++counters_.not_finite;
    return;
  }
  const Real age_s = core::seconds<Real>(pose.age(now_));
  if (age_s > static_cast<Real>(kMaxPoseAge_s) || age_s < Real(0)) {
    ++counters_.poses_stale;
    return;
  }
  const MeasurementAge<S> age = MeasurementAge<S>::of(age_s);
  const S position_x = Number::template number<Real>(pose.position_w_m.x());
  const S position_y = Number::template number<Real>(pose.position_w_m.y());
  const S position_z = Number::template number<Real>(pose.position_w_m.z());
  if (!started_) {
    return begin(pose, age);
  }
  const Real dropout_s = core::seconds<Real>(pose_.since_use);
  constexpr Real kHalf_m_s2 = static_cast<Real>(0.5 * kUnseenAcceleration_m_s2);
  const Real unseen = kHalf_m_s2 * (dropout_s * dropout_s + static_cast<Real>(kDisturbanceLag_s * kDisturbanceLag_s));
  // After a long dropout the gate is the sigmas alone. Once the prediction is abandoned, every pose goes to
  // check_reset(): weighted with the sigmas of a second without poses, one pose would set the velocity.
  const bool long_dropout = pose_.since_use > kDropout;
  if (pose_.since_use > kPoseLost) {
    check_reset(pose, age);
    return;
  }
  const Real unseen_m = long_dropout ? Real(0) : unseen;
  Real widest_m = unseen_m;
  const core::Vector<Real, 3>& sender_variance_m2 = pose.position_variance_m2;
  const auto test = [&](auto& filter, S position, Real reported, S speed, Real lag_m) {
    const Weight by = weight(reported, pose.time_sigma_s, speed, unseen_m + (long_dropout ? Real(0) : lag_m));
    const Real besides_m = Number::template real<Real>(by.unseen_m);
    widest_m = besides_m > widest_m ? besides_m : widest_m;
    return filter.test_pose(position, age, by.unseen_m, by.variance_m2);
  };
  const auto x =
      test(x_, position_x, sender_variance_m2.x(), x_.state(AxisFilter<S>::kV), lag_m<Real>(inflation_x_, dropout_s));
  const auto y =
      test(y_, position_y, sender_variance_m2.y(), y_.state(AxisFilter<S>::kV), lag_m<Real>(inflation_y_, dropout_s));
  const auto z = test(height_, position_z, sender_variance_m2.z(), height_.state(HeightFilter<S>::kClimb), Real(0));
  const S turned = yaw_.innovation(Number::template number<Real>(wrapped_yaw(pose)), age);
  if (accepts_heading(turned, x.inside && y.inside && z.inside)) {
    counters_.nis_sum += x.normalised_square() + y.normalised_square();
    correct(x_, inflation_x_, x);
    correct(y_, inflation_y_, y);
    height_.fuse_pose(z);
    inside(turned, kYawGate_rad) ? yaw_.correct(turned, age)
                                 : yaw_.reset_position(Number::template number<Real>(wrapped_yaw(pose)));
    ++counters_.poses_used;
    record_used(pose, true);
    return;
  }
  ++counters_.poses_refused;
  ++pose_.refused_in_a_row;
  pose_.refusal = refusal_of(Number::template real<Real>(turned), widest_m, x, y, z);
  check_reset(pose, age);
}

#define M100_POSES_OF(S, Real)                                                       \
  template void DisturbanceEkf<S, Real>::record_used(const core::Pose<Real>&, bool); \
  template void DisturbanceEkf<S, Real>::fuse_pose(const core::Pose<Real>&);
M100_POSES_OF(double, double)
M100_POSES_OF(float, float)
M100_POSES_OF(core::Fixed, float)
#undef M100_POSES_OF

}  // namespace m100::est
