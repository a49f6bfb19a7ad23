// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/time.h"

namespace m100::hal {

/// Ends a program that hangs. It counts by itself, beside the processor, and nothing that the program does stops it.
///
/// Twice the patience without a feed() in all: after the first the machine interrupts whatever runs, interrupt handlers
/// included, and the program says its last words; after the second the machine resets. What starts again does not take
/// control by itself.
class Watchdog {
 public:
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  /// Begins to count. @param patience positive, at most 100 s.
  virtual void start(core::Duration patience) = 0;
  /// Begins to count anew. Call it once in each period, where it shows that the period's work was done.
  virtual void feed() = 0;

 protected:
  Watchdog() = default;
  ~Watchdog() = default;
};

}  // namespace m100::hal
