// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/core/assert.h"
#include "firmware/ctl/command.h"
#include "firmware/safety/failsafe.h"
#include "firmware/safety/limits.h"
#include "firmware/safety/observation.h"

namespace m100::safety {

/// The supervisor's output.
template <typename T>
struct SupervisedCommand {
  ctl::Command<T> command{};  ///< finite, inside the envelope and its slew limits
  FailsafeState failsafe_state = FailsafeState::kSilent;
  bool transmit = false;  ///< false: no command may leave, by the failsafe
  bool release = false;   ///< true in the one tick in which control is to be given back
};

/// A step of the failsafe, with the observation that led to it.
struct FailsafeStep {
  FailsafeState from = FailsafeState::kSilent;
  FailsafeState to = FailsafeState::kSilent;
  FailsafeReason reason = FailsafeReason::kNone;
  Observation seen;
};

/// Which command passes in a tick.
enum class CommandSource : std::uint8_t { kNeutral, kLaw, kBrakeAndHold };

/// Counters since the start.
struct SupervisorStats {
  std::uint32_t steps = 0;             ///< of the failsafe
  std::uint32_t invalid_commands = 0;  ///< ticks with a number not finite, or beyond twice its range
  std::uint32_t limited_commands = 0;  ///< single numbers cut by range or slew limit, and cuts of both tilts together
  std::uint32_t coasts = 0;
  std::uint32_t levels = 0;
  std::uint32_t releases = 0;
};

/// Checks every command between the law and the wire. The failsafe (failsafe.h) chooses which command passes; then the
/// range and slew limits are applied (R5). T is float or double. Cost: about 60 comparisons, and a pass over the table
/// where state or conditions change.
template <typename T>
class Supervisor {
 public:
  /// Precondition (asserted): every range and slew limit of the envelope is above zero.
  Supervisor(const Limits& limits, const Envelope& envelope) : limits_(limits), envelope_(envelope.cast<T>()) {
    M100_ASSERT(envelope.tilt_rad > 0.0 && envelope.tilt_slew_rad_s > 0.0 && envelope.climb_m_s > 0.0 &&
                envelope.climb_slew_m_s2 > 0.0 && envelope.yaw_rate_rad_s > 0.0 && envelope.yaw_slew_rad_s2 > 0.0);
  }

  /// Once per tick, before limit_command(): updates the failsafe. The command of ctl::brake_and_hold passes in kLevel,
  /// in kRelease after kLevel, and in kCoast once the error reached the fence. Where neither it nor the law's command
  /// passes, or the law's is invalid, the command is level and trimmed.
  /// @param seen may be observation() itself
  /// @returns which command passes
  CommandSource update_failsafe(const ctl::Command<T>& wanted, const Observation& seen);
  /// Applies the limits. @param command the law's or brake_and_hold, as chosen; unused for kNeutral
  /// @param step_s the time since the last one, for the slew limits
  SupervisedCommand<T> limit_command(CommandSource passes, const ctl::Command<T>& command, T step_s);
  /// Call it instead of limit_command() while no command can leave. The last command stays. The slew limit of the next
  /// command includes `elapsed`.
  SupervisedCommand<T> hold_command(CommandSource passes, core::Duration elapsed) {
    held_for_ += elapsed;
    return limit_command(passes, last_, T(0));
  }
  /// Like hold_command(), but returns what limit_command() would make of `command`, for the log.
  SupervisedCommand<T> preview_command(CommandSource passes, const ctl::Command<T>& command, core::Duration elapsed) {
    const ctl::Command<T> last = last_;
    held_for_ += elapsed;
    const SupervisedCommand<T> granted = limit_command(passes, command, core::seconds<T>(held_for_));
    last_ = last;
    return granted;
  }
  SupervisedCommand<T> limit_command(CommandSource passes, const ctl::Command<T>& command, core::Duration elapsed) {
    const T step_s = core::seconds<T>(held_for_ + elapsed);
    held_for_ = core::Duration{0};
    return limit_command(passes, command, step_s);
  }

  FailsafeState failsafe_state() const { return failsafe_state_; }
  /// Whether the flight is ending or the autopilot flies its own task.
  bool ends() const { return failsafe_state_ == FailsafeState::kLevel || failsafe_state_ == FailsafeState::kRelease; }
  /// To be filled in place before update_failsafe(); a copy of it would cost a hundredth of a tick.
  Observation& observation() { return observed_; }
  /// The observation of the last tick.
  const Observation& observed() const { return observed_; }
  /// The conditions of the last tick.
  FailsafeCondition conditions() const { return conditions_; }
  /// The failsafe's last step; stats().steps counts them.
  const FailsafeStep& last_step() const { return last_step_; }
  /// The last step down from kNominal, or from kCoast for a reason other than its time-out.
  const FailsafeStep& descent() const { return descent_; }
  const SupervisorStats& stats() const { return stats_; }

 private:
  bool is_valid(const ctl::Command<T>& command) const;
  bool is_inside(const ctl::Command<T>& command) const;
  FailsafeCondition weigh(const ctl::Command<T>& wanted, const Observation& seen);
  void count_good_poses(const Observation& seen, bool fresh);
  void update_times(const Observation& seen, bool fresh);
  void enter(const FailsafeTransition& row, const Observation& seen);
  FailsafeReason reason_of(const FailsafeTransition& row, const Observation& seen) const;
  bool vibration_hides_faults(const Observation& seen) const;
  ctl::Command<T> limit_tilt(const ctl::Command<T>& wanted);
  ctl::Command<T> limited(const ctl::Command<T>& wanted, T step_s);
  T limited(T wanted, T last, T range, T slew, T step_s);

  Limits limits_;
  EnvelopeIn<T> envelope_;
  FailsafeState failsafe_state_ = FailsafeState::kSilent;
  std::size_t row_ = row_number(failsafe_state_, FailsafeCondition::kNone);  ///< the last tick's row of the table
  FailsafeState row_state_ = FailsafeState::kSilent;
  core::TimePoint since_{};                       ///< when the time of the present state began
  std::optional<core::TimePoint> braking_since_;  ///< kCoast: when the error exceeded the reserve to the fence
  std::uint32_t good_poses_ = 0;
  core::TimePoint last_capture_{};
  FailsafeCondition conditions_ = FailsafeCondition::kNone;
  bool ended_ = false;  ///< this tick stepped to kSilent, with control still ours
  FailsafeStep last_step_;
  FailsafeStep descent_;
  ctl::Command<T> last_{};
  core::Duration held_for_{0};  ///< since limit_command(), by the ticks that called hold_ or preview_command()
  Observation observed_;
  SupervisorStats stats_;
};

extern template class Supervisor<float>;
extern template class Supervisor<double>;

}  // namespace m100::safety
