// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>

#include "hal/clock.h"
#include "hal/watchdog.h"

namespace m100::hal {

/// A watchdog that counts by a clock which a test advances.
class ManualWatchdog final : public Watchdog {
 public:
  explicit ManualWatchdog(Clock& clock) : clock_(clock) {}

  void start(core::Duration patience) override {
    patience_ = patience;
    fed_ = clock_.now();
  }
  void feed() override {
    bites_ = bites();
    fed_ = clock_.now();
  }

  /// How often the program was interrupted (once per run of missed feeds, not once per patience).
  std::uint32_t bites() { return bites_ + static_cast<std::uint32_t>(std::min<std::int64_t>(is_expired(), 1)); }
  /// Whether the machine has been reset: twice the patience passed without a feed().
  bool has_reset() { return is_expired() >= 2; }

 private:
  std::int64_t is_expired() { return patience_ > core::Duration{0} ? (clock_.now() - fed_) / patience_ : 0; }

  Clock& clock_;
  core::Duration patience_{0};
  core::TimePoint fed_{};
  std::uint32_t bites_ = 0;
};

}  // namespace m100::hal
