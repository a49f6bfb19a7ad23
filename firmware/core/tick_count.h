// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/time.h"

namespace m100::core {

/// Counts the periods of 10 ms in the time that has passed, rounded to the nearest. The remainder is carried to the
/// next call. After a stall the missing periods are distributed over the next calls.
///
/// In each call that counts all periods that are due, the remainder shrinks by a sixteenth. Otherwise a remainder of
/// half a period could make the count alternate between 0 and 2.
class TickCount {
 public:
  static constexpr Duration kMaxBehind = std::chrono::milliseconds(500);  ///< more than this is discarded

  /// @returns 0 to `most` periods. @param elapsed since the last call, not negative
  int take(Duration elapsed, int most) {
    behind_ += elapsed;
    behind_ = behind_ > kMaxBehind ? kMaxBehind : behind_;
    // In 32 bits, which is enough for kMaxBehind: on some machines a 64-bit division is a call into a library.
    const auto rounded = static_cast<std::int32_t>((behind_ + kTickPeriod / 2).count()) / kPeriod;
    const int ticks = rounded > most ? most : rounded;
    behind_ -= ticks * kTickPeriod;
    behind_ -= ticks == rounded ? behind_ / 16 : Duration(0);
    return ticks;
  }
  /// Time that has passed but is not yet counted; negative where a period was counted before its end.
  Duration behind() const { return behind_; }

 private:
  static constexpr auto kPeriod = static_cast<std::int32_t>(kTickPeriod.count());
  Duration behind_{0};
};

}  // namespace m100::core
