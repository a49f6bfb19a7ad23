// SPDX-License-Identifier: BSD-3-Clause
#include "hal/cortex_m/systick_clock.h"

namespace m100::hal {

SysTickClock::SysTickClock(SysTickRegisters& registers, std::uint32_t clock_hz, std::uint32_t period_us)
    : registers_(registers), cycles_per_us_(clock_hz / 1000000U), cycles_per_period_(cycles_per_us_ * period_us) {}

void SysTickClock::start() {
  constexpr std::uint32_t kOnWithInterrupt = 0x7U;
  registers_.reload = cycles_per_period_ - 1U;
  registers_.value = 0U;
  registers_.control = kOnWithInterrupt;
}

std::uint64_t SysTickClock::cycles() const {
  // A period may end between the two reads of periods_; then the counter has just restarted, and is read again.
  std::uint32_t before = periods_.load(std::memory_order_acquire);
  std::uint32_t value = registers_.value;
  const std::uint32_t after = periods_.load(std::memory_order_acquire);
  if (after != before) {
    before = after;
    value = registers_.value;
  }
  // The interrupt comes with the step to 0, so 0 is the first cycle of a period, the reload value its second.
  const std::uint32_t into_period = value == 0U ? 0U : cycles_per_period_ - value;
  return std::uint64_t{before} * cycles_per_period_ + into_period;
}

core::TimePoint SysTickClock::now() {
  return core::TimePoint(core::Duration(static_cast<std::int64_t>(cycles() / cycles_per_us_)));
}

void SysTickClock::sleep_until(core::TimePoint deadline) {
  while (now() < deadline) {
  }
}

}  // namespace m100::hal
