// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "firmware/core/assert.h"
#include "firmware/core/fixed_point.h"
#include "firmware/core/tick_count.h"
#include "firmware/core/tilt.h"
#include "firmware/core/time.h"
#include "firmware/ctl/command.h"
#include "firmware/est/axis_filter.h"
#include "firmware/est/estimate.h"
#include "firmware/est/height_filter.h"
#include "firmware/est/lag_watch.h"
#include "firmware/est/measurement.h"
#include "firmware/est/yaw_filter.h"
#include "firmware/model/vehicle.h"

namespace m100::est {

/// Why the filter last gave up a belief instead of correcting it.
enum class Recovery : std::uint8_t {
  kNone,
  kPoseMoved,    ///< poses were refused, agreed with each other, and won: position taken anew, velocity uncertain
  kLongDropout,  ///< no pose for more than 0.5 s, and the next ones were outside the gate
  kAttitude,     ///< attitudes were refused for 0.5 s: started anew
  kNotFinite,    ///< a state was not a number: started anew
};
std::string_view name(Recovery recovery);

/// Counts since the start; health outputs for the log.
struct EkfCounters {
  std::uint32_t poses_used = 0;
  std::uint32_t poses_refused = 0;      ///< by the innovation gate
  std::uint32_t poses_stale = 0;        ///< older than kMaxPoseAge_s
  std::uint32_t attitudes_refused = 0;  ///< by the gate, or beyond 1.2 rad
  std::uint32_t not_finite = 0;         ///< measurements or commands that were not numbers, dropped
  std::uint32_t recoveries = 0;
  Recovery last_recovery = Recovery::kNone;
  /// Normalised squares of the innovations (NIS) of all poses that were used, both horizontal axes: 2 for each is
  /// right.
  float nis_sum = 0.F;
  CovarianceHealth covariance;  ///< of all parts together
};

/// Telemetry and commands in, state and disturbance out: two horizontal axes (AxisFilter), height, yaw.
///
/// The command is the one in force since the last tick (after supervisor, rate limit and stick rounding: what the
/// autopilot was really told); it acts a transport delay later. Poses may be up to 0.25 s old; the filter is told their
/// age. A measurement or command that is not a number is dropped and counted; a state that is not one lives for one
/// call at most.
///
/// Gate: a pose beyond 6 sigmas in x, y or z, or 0.35 rad in yaw, is refused; the sigmas have in them how far the
/// aircraft flies in the uncertainty of the time of capture. After a dropout of t < 0.5 s what wind can have done
/// meanwhile (1.5 m/s^2 t^2) is let through. From 0.1 s without a pose on, the disturbance follows what the force shows
/// (Measurement::push): the drag of the speed, which braking takes away, and gusts. Way back: refused poses that follow
/// from each other for 0.5 s (at most once in 2 s), or 3 of them after a dropout of more than 0.5 s, are taken as
/// position and, by their difference over at least 0.1 s, as velocity; disturbance and offset stay. The reason is in
/// the counters. S: double, float or core::Fixed; inputs and outputs are of type Real. Cost: firmware/README.md; after
/// a stall at most kMaxTicks ticks are caught up in a call, and no pose is used until the state is of the present.
template <typename S, typename Real>
class DisturbanceEkf {
 public:
  static constexpr int kMaxTicks = 5;

  explicit DisturbanceEkf(const model::Vehicle& vehicle);

  /// One tick: from the last call to now, `elapsed` later. Whole ticks are predicted (core::TickCount), 0 to kMaxTicks.
  Estimate<Real> update(const Measurement<Real>& measured, const ctl::Command<Real>& in_force, core::Duration elapsed);

  EkfCounters counters() const;
  /// The tilt about both axes of the yaw-free frame that the commands alone make by the model; rad.
  core::Vector<Real, 2> asked_tilt_rad() const {
    return {core::Arithmetic<S>::template real<Real>(x_.asked_tilt()),
            core::Arithmetic<S>::template real<Real>(y_.asked_tilt())};
  }

 private:
  /// Commands of the past in the filter's frame; [0] is the newest.
  struct Sent {
    S x{}, y{}, climb{};
  };
  struct Delay {
    std::size_t ticks = 0;
    S rest{};  ///< of a tick
  };
  static constexpr std::size_t kSentCapacity = 64;

  static Delay delay_of(double delay_s);
  static AxisModel axis_model(const model::Vehicle& vehicle, const model::StickAxis& axis, double sign);
  const Sent& sent(std::size_t ago) const {
    M100_ASSERT(ago < kSentCapacity);
    return sent_[(newest_ + kSentCapacity - ago) % kSentCapacity];
  }
  void note_command(const ctl::Command<Real>& in_force);
  ActingInputs<S> inputs(const Delay& delay, S Sent::*axis);
  void predict_tick();
  void use_attitude(const typename Measurement<Real>::Attitude& attitude);
  void use_pose(const core::Pose<Real>& pose);
  void feel(const Push<Real>& push);
  /// What a pose counts for on one axis, and how far from the state it may be besides.
  struct Weight {
    float variance_m2 = 0.F;
    S unseen_m{};
  };
  /// Its variance: the larger of what the vehicle file and the sender say, and the way in the uncertainty of its time,
  /// of which the gate has the whole and the filter at most kMostWay_m.
  Weight weight(Real told_m2, Real time_sigma_s, S speed, Real unseen_m) const;
  /// Notes a pose that does not follow from the state. @returns true when it follows from the one before.
  bool agrees(const core::Pose<Real>& pose);
  void begin(const core::Pose<Real>& pose);
  void note_used(core::Duration pose_age, Real time_sigma_s);
  void judge_refused(const core::Pose<Real>& pose, const Age<S>& age);
  /// How often a sigma of a horizontal axis was halved at its ceiling: the covariance says no longer how the errors go
  /// together, and a pose's innovation would be shared out wrongly.
  std::uint32_t ceilings_met() const { return x_.health().ceilings + y_.health().ceilings; }
  /// Velocity over the poses since `first_pose_`, with what the tilt has added meanwhile, in m per unit of time.
  core::Vector<Real, 3> velocity_since_first(const core::Pose<Real>& pose, Real tilt_x_rad, Real tilt_y_rad) const;
  void recover(Recovery reason);
  void restart();
  Estimate<Real> estimate() const;
  AxisEstimate<Real> estimate_of(const AxisFilter<S>& filter, const LagWatch<Real>& lag) const;
  /// A pose that passed the gate, on one axis.
  void correct(AxisFilter<S>& filter, LagWatch<Real>& lag, const typename AxisFilter<S>::PoseTest& test);

  AxisFilter<S> x_;
  AxisFilter<S> y_;
  LagWatch<Real> lag_x_, lag_y_;
  HeightFilter<S> height_;
  YawFilter<S> yaw_;
  Delay delay_x_, delay_y_, delay_climb_;
  core::Arithmetic<S> arithmetic_;
  std::array<Sent, kSentCapacity> sent_{};
  std::size_t newest_ = 0;
  ctl::Command<Real> last_command_{};
  core::StandingSlope<Real> told_;
  core::StandingTurn<Real> heading_;
  Real pose_variance_m2_;  ///< of the vehicle file
  S gyro_yaw_rate_{};
  bool push_noted_ = false;  ///< at the newest pose that was used, or since
  bool attitude_known_ = false;
  bool attitude_refused_ = false;  ///< the newest one, for whatever reason
  bool started_ = false;
  core::Euler<Real> attitude_{};
  core::Duration since_start_{0};
  core::Duration since_attitude_{0};
  core::Duration since_pose_{0};  ///< since the last pose that was used
  core::TimePoint now_{};         ///< of this tick, for ages
  core::TickCount time_;          ///< how far the state is behind it
  core::Duration pose_age_{0};
  core::Duration since_recovery_ = std::chrono::seconds(2);
  std::uint32_t refused_in_a_row_ = 0;
  std::uint32_t ceilings_at_pose_ = 0;  ///< ceilings_met() when a pose was last used
  Refusal<Real> refusal_;
  std::uint32_t attitudes_refused_in_a_row_ = 0;
  std::uint32_t agreeing_ = 0;    ///< poses in a row that follow from each other but not from the state
  core::Pose<Real> last_pose_{};  ///< of those
  core::Pose<Real> first_pose_{};
  core::Duration since_last_{0};  ///< since the moment at which it was true
  core::Duration since_first_{0};
  core::TimePoint agreeing_since_{};  ///< when the first of them came
  core::TimePoint agreeing_until_{};  ///< when the last of them came: silence refuses nothing
  Real time_sigma_s_{0};              ///< of the newest pose that was used
  EkfCounters counters_;
};

using DoubleEkf = DisturbanceEkf<double, double>;
using FloatEkf = DisturbanceEkf<float, float>;
using FixedEkf = DisturbanceEkf<core::Fixed, float>;

}  // namespace m100::est
