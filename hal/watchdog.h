// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/time.h"

namespace m100::hal {

/// Ends a program that hangs. On Linux the service manager does so, after one patience (ServiceWatchdog).
///
/// On a board the watchdog cannot be stopped. After one patience without a feed() the machine interrupts all code, also
/// interrupt handlers, and the program sends its release sequence. After a second patience the machine resets. The
/// restarted program does not take control by itself.
class Watchdog {
 public:
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  /// Starts to count. @param patience time-out of each stage, positive, at most 100 s.
  virtual void start(core::Duration patience) = 0;
  /// Restarts the count. Call it once in each period, at a place that shows that the period's work was done.
  virtual void feed() = 0;

 protected:
  Watchdog() = default;
  ~Watchdog() = default;
};

}  // namespace m100::hal
