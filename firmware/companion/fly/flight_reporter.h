// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/fly/autopilot_task.h"
#include "firmware/companion/fly/monitor/tracking_error.h"
#include "firmware/companion/ground_station/return_to_start.h"
#include "firmware/companion/operator/operator_log.h"

namespace m100::companion {

/// Tells the operator each change of a flight once: authority, failsafe, excitation, limit cycle, a heading of the
/// autopilot that turned alone, vibration, a jump that the pose source announced, return to the start.
/// No heap.
class FlightReporter {
 public:
  static constexpr std::size_t kMaxTransitions = 64;  ///< steps of the failsafe that are kept: the first ones

  /// @param lands a flight that has returned to its start lands there.
  FlightReporter(const app::FlightController<double>& controller, const safety::Limits& limits, bool lands,
                 OperatorLog& operator_log)
      : controller_(controller), limits_(limits), lands_(lands), operator_log_(operator_log) {}

  /// Once per tick, before the sequencer decides. @param is_flying the sequencer is in its flying phase. The tracking
  /// error is updated only in this phase and while the failsafe lets the law's command pass.
  void update(core::TimePoint now, bool is_flying);
  void update_return(const ReturnToStart<double>& home, core::TimePoint now);

  /// The observation when the first limit cycle was noticed; empty: none was.
  const std::optional<safety::Observation>& limit_cycle() const { return limit_cycle_; }
  std::span<const safety::FailsafeStep> steps() const { return std::span(steps_).first(step_count_); }
  const TrackingError& tracking() const { return tracking_; }
  /// The strongest vibration while the law flew.
  const est::VibrationStatus& vibration() const { return vibration_; }
  /// Says that a take-off or a landing was ordered, or how it ended. @param outside a take-off ended beyond the fence
  void report_task(core::TimePoint now, const AutopilotTask& task, bool outside = false);
  /// Says why control is not granted, after `how`. @param next what the operator may do; empty: nothing
  void report_refusal(core::TimePoint now, std::string_view how, const link::AuthorityView& authority,
                      std::string_view next = {});
  /// Says that the autopilot lands although nobody ordered it.
  void report_landing(core::TimePoint now);
  /// Says why the flight has ended, and what may follow.
  /// @param denial why control was not used, if the law has not flown
  void report_end(core::TimePoint now, const link::AuthorityView& authority,
                  std::optional<safety::FailsafeReason> denial, bool takes_off, std::string_view next);
  /// Reports the tracking error once per program, if the law has flown for longer than TrackingError::kSettle.
  void report_tracking(core::TimePoint now);
  /// @returns `step`, with each age and distance raised to its largest value since the failsafe was last nominal. So
  ///   the report shows how far a limit was exceeded in the end.
  safety::Observation worst_since(const safety::Observation& step) const;

 private:
  void report_stage(core::TimePoint now);
  void report_failsafe(core::TimePoint now);
  void report_excitation(core::TimePoint now);
  void report_limit_cycle(core::TimePoint now);
  void report_heading(core::TimePoint now);
  void report_jump(core::TimePoint now);
  void report_vibration(core::TimePoint now, bool is_flying);
  void note_flight(core::TimePoint now, bool is_flying);

  const app::FlightController<double>& controller_;
  safety::Limits limits_;
  bool lands_;
  OperatorLog& operator_log_;
  bool reported_stage_ = false;
  safety::AuthorityStage last_stage_ = safety::AuthorityStage::kListening;
  safety::AuthorityReason last_reason_ = safety::AuthorityReason::kNone;
  std::uint32_t reported_transitions_ = 0;
  std::array<safety::FailsafeStep, kMaxTransitions> steps_{};
  std::size_t step_count_ = 0;
  ctl::Excitation<double>::State reported_excitation_ = ctl::Excitation<double>::State::kIdle;
  bool limit_cycle_reported_ = false;
  /// What was reported of the headings, the vibration and the source's world.
  struct {
    bool heading = false;
    bool vibration = false;
    std::uint32_t jumps = 0;
    std::array<core::TimePoint, 9> jumps_at{};  ///< the last nine, in a ring
  } reported_;
  std::optional<safety::Observation> limit_cycle_;
  ReturnToStart<double>::State reported_return_ = ReturnToStart<double>::State::kInactive;
  TrackingError tracking_;
  est::VibrationStatus vibration_;
  bool tracking_reported_ = false;
  safety::Observation worst_;  ///< the largest ages and distances since the failsafe was last nominal
};

}  // namespace m100::companion
