// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/time.h"

namespace m100::core {

/// Counts the whole periods of 10 ms in the time that has really passed. What is over is carried, so that neither a
/// late tick nor the short one behind it makes time; what a stall leaves is handed out over the next calls.
///
/// A rest of less than half a period fades (a sixteenth at each call), because the clock of the loop may have been set
/// anew, and a count that stands between two ticks would give 0 and 2 in turn.
class TickCount {
 public:
  static constexpr Duration kMostBehind = std::chrono::milliseconds(500);  ///< what is more is lost

  /// @returns 0 to `most` periods. @param elapsed since the last call, not negative
  int take(Duration elapsed, int most) {
    behind_ += elapsed;
    behind_ = behind_ > kMostBehind ? kMostBehind : behind_;
    // In 32 bits, which the most fits into: a division of 64 is a call into the compiler's library on some machines.
    const auto rounded = static_cast<std::int32_t>((behind_ + kTickPeriod / 2).count()) / kPeriod;
    const int ticks = rounded > most ? most : rounded;
    behind_ -= ticks * kTickPeriod;
    behind_ -= ticks == rounded ? behind_ / 16 : Duration(0);
    return ticks;
  }
  /// Passed and not yet counted; negative where a period was counted before its end.
  Duration behind() const { return behind_; }

 private:
  static constexpr auto kPeriod = static_cast<std::int32_t>(kTickPeriod.count());
  Duration behind_{0};
};

}  // namespace m100::core
