// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>

namespace m100::core {

/// The one clock of a flight: monotonic, microseconds since the program started. It has no now(): main reads the time
/// once per tick, or a test sets it, and passes it down.
struct FlightClock {
  using rep = std::int64_t;
  using period = std::micro;
  using duration = std::chrono::duration<rep, period>;
  using time_point = std::chrono::time_point<FlightClock>;
  static constexpr bool is_steady = true;
};

using Duration = FlightClock::duration;
using TimePoint = FlightClock::time_point;

/// Seconds as a floating-point number of type T.
template <typename T>
constexpr T seconds(Duration duration) {
  const std::int64_t count_us = duration.count();
  const auto short_us = static_cast<std::int32_t>(count_us);
  // Both conversions give the same number; up to half an hour the processor does it, beyond that a library function.
  return (short_us == count_us ? static_cast<T>(short_us) : static_cast<T>(count_us)) / static_cast<T>(1000000);
}

/// The period of the control loop (paper, IV-B: every box runs at 100 Hz).
inline constexpr Duration kTickPeriod = std::chrono::milliseconds(10);

}  // namespace m100::core
