// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/time.h"

namespace m100::hal {

/// Monotonic time since the program started, in microseconds. Steps of the wall clock do not change it.
class Clock {
 public:
  Clock(const Clock&) = delete;
  Clock& operator=(const Clock&) = delete;

  virtual core::TimePoint now() = 0;

  /// Returns at the deadline, or as soon after it as the machine can; at once if it has passed. Deadlines are absolute,
  /// so that the lateness of one tick does not carry over to the next.
  virtual void sleep_until(core::TimePoint deadline) = 0;

 protected:
  Clock() = default;
  ~Clock() = default;
};

}  // namespace m100::hal
