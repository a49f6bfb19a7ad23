// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/operator/clock_step_recorder.h"
#include "firmware/companion/operator/operator_log.h"
#include "firmware/companion/operator/text_line.h"

namespace m100::companion {

/// Watches the source of pose, and prevents control before it is requested: for a second sender, for an attitude that
/// the autopilot's contradicts, and for a check that failed and has not yet passed long enough.
///
/// A failed check must pass for kHold, or for four times the time to its failure if that is longer, because the slow
/// wander of a hover takes time to repeat the motion at which it failed. No heap.
class PoseMonitor {
 public:
  static constexpr core::Duration kHold = std::chrono::seconds(30);
  /// The operator is warned of a lower rate, with which a failure of the source is noticed later. 50 Hz are asked for;
  /// a source of nominally 50 Hz that loses a pose now and then is not warned of.
  static constexpr double kMinPoses_hz = 45.0;

  /// Call it after each tick. @param waits control is not ours and was not requested
  void tick(core::TimePoint now, const app::FlightController<double>& controller, bool waits, OperatorLog& listener);
  /// Whether control may not be requested.
  bool blocks(core::TimePoint now) const { return rival_ || is_tilted(now) || is_on_trial(now); }
  bool has_rival() const { return rival_; }
  /// If blocks(): the only cause is a check that failed and must hold for longer.
  bool is_on_trial_only(core::TimePoint now) const { return !rival_ && !is_tilted(now); }
  /// Why control may not be requested, in words that follow "control is not asked for: ".
  void describe(TextLine& line, const app::FlightController<double>& controller, core::TimePoint now) const;
  std::span<const ClockStep> clock_steps() const { return clock_steps_.steps(); }

 private:
  bool is_tilted(core::TimePoint now) const {
    return now - tilted_since_ > kTiltLasts && tilt_apart_rad_ > kMaxTilt_rad;
  }
  bool is_on_trial(core::TimePoint now) const { return failed_ && now - failed_at_ < hold_; }
  void watch_tilt(core::TimePoint now, const app::FlightController<double>& controller);
  void watch_rate(core::TimePoint now, const link::PoseLink& pose, OperatorLog& listener);
  void watch_rival(core::TimePoint now, const app::FlightController<double>& controller, bool waits,
                   OperatorLog& listener);

  /// Trim, mounting and tracking add up to some degrees; a wrong quaternion order or axis gives more than this (15
  /// degrees) at almost every heading.
  static constexpr double kMaxTilt_rad = 0.26;
  static constexpr core::Duration kTiltLasts = std::chrono::milliseconds(300);

  bool rival_ = false;
  bool rival_said_ = false;
  bool rate_judged_ = false;
  double tilt_apart_rad_ = 0.0;
  double pose_tilt_rad_ = 0.0;
  double autopilot_tilt_rad_ = 0.0;
  core::Vector<double, 3> up_b_ = core::Vector<double, 3>::Zero();  ///< mean, by the autopilot's attitude
  core::TimePoint tilted_since_{};
  bool failed_ = false;
  core::TimePoint failed_at_{};
  core::TimePoint looks_since_{};
  core::Duration hold_{0};
  ClockStepRecorder clock_steps_;
};

}  // namespace m100::companion
