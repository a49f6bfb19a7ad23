// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/ctl/command.h"
#include "firmware/safety/ladder.h"
#include "firmware/safety/limits.h"
#include "firmware/safety/observation.h"

namespace m100::safety {

/// What the supervisor lets through.
template <typename T>
struct Grant {
  ctl::Command<T> command{};  ///< finite, inside the envelope and its slew limits
  Rung rung = Rung::kSilent;
  bool transmit = false;  ///< whether a control byte may leave at all
  bool release = false;   ///< true in the one tick in which control is to be given back
};

/// A step of the ladder, with what was seen when it was made.
struct LadderStep {
  Rung from = Rung::kSilent;
  Rung to = Rung::kSilent;
  Cause cause = Cause::kNone;
  Observation seen;
};

/// Which command passes in a tick.
enum class Passes : std::uint8_t { kNeither, kWanted, kSettled };

/// Counters for the log.
struct SupervisorStats {
  std::uint32_t steps = 0;             ///< of the ladder
  std::uint32_t unsound_commands = 0;  ///< not finite, or beyond twice the envelope
  std::uint32_t limited_commands = 0;  ///< cut by range or slew
  std::uint32_t coasts = 0;
  std::uint32_t levels = 0;
  std::uint32_t releases = 0;
};

/// Stands between the law and the wire and may only take away: the ladder of ladder.h, then range and slew (R5).
///
/// Cost: one pass over some 20 table rows, about 60 comparisons. No state but the ladder's, its clock and the last
/// command. T is float or double.
template <typename T>
class Supervisor {
 public:
  Supervisor(const Limits& limits, const Envelope& envelope) : limits_(limits), envelope_(envelope.cast<T>()) {}

  /// Once per tick. @param step_s the time since the last one, for the slew limits.
  /// @param settled what may leave in kLevel; in kRelease only where LEVEL led
  ///   there with a fresh pose. Else, and where it is unsound: level and trimmed
  Grant<T> review(const ctl::Command<T>& wanted, const ctl::Command<T>& settled, const Observation& seen, T step_s) {
    const Passes passes = climb(wanted, seen);
    return let_through(passes, passes == Passes::kWanted ? wanted : settled, step_s);
  }
  /// The same in two halves, for who computes the settled command only where it is asked for: first the ladder, ...
  Passes climb(const ctl::Command<T>& wanted, const Observation& seen);
  /// ... then the limits. @param command of the two the one that passes; looked at by nobody where none does
  Grant<T> let_through(Passes passes, const ctl::Command<T>& command, T step_s);

  Rung rung() const { return rung_; }
  /// What the table saw in the last tick.
  LadderSign signs() const { return signs_; }
  /// The ladder's last step; stats().steps counts them.
  const LadderStep& last_step() const { return last_step_; }
  /// The step that ended the last flight by the law, or leads there now: where the descent began.
  const LadderStep& descent() const { return descent_; }
  const SupervisorStats& stats() const { return stats_; }

 private:
  bool is_sound(const ctl::Command<T>& command) const;
  LadderSign weigh(const ctl::Command<T>& wanted, const Observation& seen);
  void count_good_poses(const Observation& seen, bool fresh);
  void note_reserve(const Observation& seen);
  void note_known(const Observation& seen, bool fresh);
  void enter(const LadderRow& row, const Observation& seen);
  Cause cause_of(const LadderRow& row, const Observation& seen) const;
  ctl::Command<T> leaning(const ctl::Command<T>& wanted);
  ctl::Command<T> limited(const ctl::Command<T>& wanted, T step_s);
  T limited(T wanted, T last, T range, T slew, T step_s);

  Limits limits_;
  EnvelopeIn<T> envelope_;
  Rung rung_ = Rung::kSilent;
  core::TimePoint entered_{};
  bool spent_ = false;  ///< kCoast: the reserve to the fence, and the place was not known again since
  core::TimePoint spent_since_{};
  core::TimePoint known_{};  ///< kCoast: when the place was last known as well as when it began
  std::uint32_t good_poses_ = 0;
  core::TimePoint last_capture_{};
  LadderSign signs_ = LadderSign::kNone;
  bool ended_ = false;  ///< the last tick led from kRelease to kSilent, with control still ours
  LadderStep last_step_;
  LadderStep descent_;
  ctl::Command<T> last_{};
  SupervisorStats stats_;
};

extern template class Supervisor<float>;
extern template class Supervisor<double>;

}  // namespace m100::safety
