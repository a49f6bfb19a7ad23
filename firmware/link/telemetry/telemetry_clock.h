// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/time.h"

namespace m100::link {

/// Distinguishes new telemetry from repeated telemetry by the autopilot's own clock in it. A repeated package must not
/// count as the present state: it could show that the transmitter has control when it has not (promise R15).
///
/// A package is new if its clock is ahead of all previous ones. A step of the clock that differs from ours by more than
/// a second, or goes back by more than a second, is a restart of the autopilot, which is reported at once. The first
/// package of the new clock is not new; the next one is if its clock is ahead of that.
class TelemetryClock {
 public:
  /// The autopilot counts ticks of 400 Hz.
  static constexpr core::Duration kTick = std::chrono::microseconds(2500);
  /// The autopilot restarted if its clock goes back by more than this, or advances by this much more or less than ours.
  static constexpr core::Duration kJump = std::chrono::seconds(1);

  struct Verdict {
    bool is_new = false;
    bool restarted = false;
  };
  /// @param ticks of the package. @param earliest, latest it arrived between these two times.
  Verdict update(std::uint32_t ticks, core::TimePoint earliest, core::TimePoint latest);
  void reset() { trusted_.known = after_jump_.known = false; }

 private:
  enum class Step { kOnwards, kBack, kJump };
  struct Mark {
    bool known = false;
    std::uint32_t ticks = 0;
    core::TimePoint earliest{};
    core::TimePoint latest{};
  };
  static Step step_of(const Mark& from, const Mark& to);

  Mark trusted_;
  Mark after_jump_;
};

}  // namespace m100::link
