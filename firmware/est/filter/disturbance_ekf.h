// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

#include "firmware/core/tick_count.h"
#include "firmware/core/tilt.h"
#include "firmware/core/time.h"
#include "firmware/ctl/command.h"
#include "firmware/est/estimate.h"
#include "firmware/est/filter/axis_filter.h"
#include "firmware/est/filter/command_history.h"
#include "firmware/est/filter/covariance_inflation.h"
#include "firmware/est/filter/heading_vote.h"
#include "firmware/est/filter/height_filter.h"
#include "firmware/est/filter/pose_agreement.h"
#include "firmware/est/filter/yaw_filter.h"
#include "firmware/est/measurement.h"
#include "firmware/model/vehicle.h"

namespace m100::est {

/// Why the filter last discarded a state instead of correcting it.
enum class ResetReason : std::uint8_t {
  kNone,
  kPoseMoved,    ///< refused poses agreed with each other: position, velocity and yaw taken from them
  kLongDropout,  ///< no pose used for 0.5 s, then refused poses that agreed: state taken from them
  kAttitude,     ///< 50 attitudes in a row outside the filters' gate (0.5 s at 100 Hz), at most once in 2 s: restart
  kNotFinite,    ///< a state or a variance was not valid: restart
};
std::string_view name(ResetReason recovery);

/// Whether a heading that the gate refused may become the estimate's.
enum class HeadingReset : std::uint8_t {
  kFree,       ///< with the position, from refused poses that agree with each other
  kConfirmed,  ///< if the autopilot's heading turned by as much, and the poses follow the predicted motion for 0.3 s
  kNever,
};

/// The roll and pitch with which the observer predicts: those of [design], or the identified ones (paper, III-E.1: the
/// law's model is another than the observer's). Both have the transport delays of [design].
enum class Tilts : std::uint8_t { kDesigned, kIdentified };

/// Counts since the start; health outputs for the log.
struct EkfCounters {
  std::uint32_t poses_used = 0;
  std::uint32_t poses_refused = 0;      ///< by the innovation gate
  std::uint32_t poses_stale = 0;        ///< older than kMaxPoseAge_s, or captured in the future
  std::uint32_t attitudes_refused = 0;  ///< by the gate, or beyond 1.2 rad or 20 rad/s
  std::uint32_t not_finite = 0;         ///< measurements or commands that were not finite, dropped
  std::uint32_t recoveries = 0;
  ResetReason last_recovery = ResetReason::kNone;
  /// Sum of the normalised squared innovations (NIS) of all used poses, both horizontal axes; expected: 2 per pose.
  float nis_sum = 0.F;
};

/// Estimates state and disturbance from telemetry and commands: two horizontal axes (AxisFilter), height, yaw.
///
/// The command is the one that the autopilot has received since the last tick; it acts a transport delay later. Poses
/// may be up to 0.25 s old. A measurement or command that is not finite is dropped and counted. A state that is not
/// finite restarts the filter.
///
/// Gate: a pose beyond 6 sigmas in x, y or z, or beyond 0.35 rad in yaw, is refused. For 0.5 s after the last used pose
/// the gate also passes the distance that wind may have moved the aircraft. It never passes more than 1 m.
/// Without poses for 0.1 s, the disturbance follows the measured specific force
/// (Measurement::disturbance_acceleration).
/// Recovery: refused poses that agree with each other for long enough set position and velocity. HeadingReset says
/// whether they set the yaw. Disturbance and input offset stay.
/// S is double, float or core::Fixed; inputs and outputs are of type Real. Cost: firmware/RESULTS.md.
template <typename S, typename Real>
class DisturbanceEkf {
 public:
  /// Largest number of ticks that one call predicts. It covers the longest stall after which a flight goes on
  /// (kOwnStall in serial_link.cpp).
  static constexpr int kMaxTicks = 50;

  explicit DisturbanceEkf(const model::Vehicle& vehicle, Tilts tilts = Tilts::kDesigned);

  /// Call it once per controller tick, `elapsed` after the last call. It predicts as many periods of 10 ms as
  /// core::TickCount counts, 0 to kMaxTicks. While more than one period is left, no pose is used.
  const Estimate<Real>& update(const Measurement<Real>& measured, const ctl::Command<Real>& applied_command,
                               core::Duration elapsed, HeadingReset heading_reset = HeadingReset::kFree);
  /// The result of the last update().
  const Estimate<Real>& estimate() const { return estimate_; }

  const EkfCounters& counters() const { return counters_; }
  /// Subtracts the share of the input offset that the sticks' neutrals took over. Until the next stick acts, the tilt
  /// is wrong by the share of one delay, 0.1 s, in kLearned_s of TrimMonitor: 5 % of the offset.
  void reduce_input_offset(Real share) {
    x_.reduce_input_offset(S(share));
    y_.reduce_input_offset(S(share));
  }
  /// The tilt about both axes of the yaw-free frame that the model predicts from the commands alone; rad.
  core::Vector<Real, 2> model_tilt_rad() const {
    return {static_cast<Real>(x_.model_tilt()), static_cast<Real>(y_.model_tilt())};
  }

 private:
  void predict_tick();
  void fuse_attitude(const typename Measurement<Real>::Attitude& attitude);
  void fuse_pose(const core::Pose<Real>& pose);
  void fuse_specific_force(const DisturbanceAcceleration<Real>& disturbance_acceleration);
  /// Starts the filter when an attitude is known and a row of agreeing poses spans kBaseline. These poses also give the
  /// initial velocity.
  void begin(const core::Pose<Real>& pose);
  /// Sets position, velocity and, if `with_heading`, yaw from the newest of a row of agreeing poses.
  void set_motion(const core::Pose<Real>& pose, bool with_heading);
  /// Records that this pose has corrected, started or reset the state.
  void record_used(const core::Pose<Real>& pose, bool heading_used);
  void check_reset(const core::Pose<Real>& pose);
  /// Whether a pose that turned by so much may correct the state: it follows the predicted motion, and its heading lies
  /// inside the gate or is confirmed (HeadingReset::kConfirmed). A source that announces its reset would count here.
  bool accepts_heading(Real turned_rad, bool follows);
  void recover(ResetReason reason);
  void restart();
  void update_estimate();
  AxisEstimate<Real> estimate_of(const AxisFilter<S>& filter, const CovarianceInflation<Real>& lag,
                                 Real measured_tilt_rad) const;
  /// Corrects one axis by a pose that passed the gate.
  void correct(AxisFilter<S>& filter, CovarianceInflation<Real>& lag, const PoseInnovation<S>& test);

  AxisFilter<S> x_;
  AxisFilter<S> y_;
  CovarianceInflation<Real> inflation_x_, inflation_y_;
  HeightFilter<S> height_;
  YawFilter<S> yaw_;
  CommandHistory<Real> commands_;
  core::CachedSinCos<Real> heading_;
  Real pose_variance_m2_;  ///< the vehicle file's
  bool started_ = false;
  core::Duration since_start_{0};
  core::Duration since_recovery_ = std::chrono::seconds(2);
  core::TimePoint now_{};  ///< of this tick, for ages
  core::TickCount time_;   ///< how far the state lags behind now_
  /// The newest attitude.
  struct {
    bool is_known = false;
    bool is_refused = false;  ///< for whatever reason
    std::uint32_t refused_in_a_row = 0;
    core::Duration age{0};  ///< of the newest that was used
    core::Euler<Real> angles{};
    core::Tilt<Real> tilt{};  ///< of the newest that was used
    HeadingVote<Real> vote;
    Real yaw_rate_rad_s{0};  ///< that counts, see HeadingVote
  } attitude_;
  /// The newest pose that was used, and the refused ones after it.
  struct {
    core::Duration since_use{0};
    core::Duration age{0};
    Real time_sigma_s{0};
    bool acceleration_stored = false;  ///< the filters have stored a measured disturbance
    std::uint32_t refused_in_a_row = 0;
    Refusal<Real> refusal;
    HeadingReset heading_reset = HeadingReset::kFree;  ///< of this tick
    core::TimePoint turned_since{};                    ///< since then poses have been refused by their heading alone
  } pose_;
  PoseAgreement<Real> agreement_;  ///< of the poses before the start, and of refused ones
  EkfCounters counters_;
  Estimate<Real> estimate_;
};

using DoubleEkf = DisturbanceEkf<double, double>;
using FloatEkf = DisturbanceEkf<float, float>;
using FixedEkf = DisturbanceEkf<core::Fixed, float>;

}  // namespace m100::est
