// SPDX-License-Identifier: BSD-3-Clause
#include "hal/cortex_m/cmsdk_watchdog.h"

#include "firmware/core/assert.h"

namespace m100::hal {
namespace {

constexpr std::uint32_t kUnlocks = 0x1ACCE551U;
constexpr std::uint32_t kLocks = 0U;
constexpr std::uint32_t kInterruptThenReset = 0x3U;
constexpr std::uint64_t kMicrosPerSecond = 1000000;

}  // namespace

// The registers are locked between accesses, so that a stray write of the program does not stop its watchdog.
void CmsdkWatchdog::start(core::Duration patience) {
  const auto cycles = static_cast<std::uint64_t>(patience.count()) * clock_hz_ / kMicrosPerSecond;
  // A patience that the register cannot hold would be another one.
  M100_ASSERT(patience > core::Duration{0} && cycles > 0 && cycles <= UINT32_MAX);
  lock_ = kUnlocks;
  registers_.load = static_cast<std::uint32_t>(cycles);
  registers_.interrupt_clear = 1;
  registers_.control = kInterruptThenReset;
  lock_ = kLocks;
}

void CmsdkWatchdog::feed() {
  lock_ = kUnlocks;
  registers_.interrupt_clear = 1;
  lock_ = kLocks;
}

}  // namespace m100::hal
