// SPDX-License-Identifier: BSD-3-Clause
#include "hal/linux/monotonic_clock.h"

#include <time.h>

#include <cerrno>

namespace m100::hal {
namespace {

constexpr std::int64_t kMicrosPerSecond = 1000000;

core::Duration since_boot() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return core::Duration{std::int64_t{now.tv_sec} * kMicrosPerSecond + now.tv_nsec / 1000};
}

}  // namespace

MonotonicClock::MonotonicClock(const SystemCalls& calls) : calls_(&calls), start_(since_boot()) {}

core::TimePoint MonotonicClock::now() { return core::TimePoint{since_boot() - start_}; }

void MonotonicClock::sleep_until(core::TimePoint deadline) {
  const std::int64_t wake_us = (start_ + deadline.time_since_epoch()).count();
  if (wake_us <= 0) {
    return;
  }
  timespec wake{};
  wake.tv_sec = static_cast<time_t>(wake_us / kMicrosPerSecond);
  wake.tv_nsec = static_cast<long>(wake_us % kMicrosPerSecond) * 1000;
  while (calls_->sleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr) == EINTR) {
  }
}

}  // namespace m100::hal
