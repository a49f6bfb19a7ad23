// SPDX-License-Identifier: BSD-3-Clause
#include "hal/cortex_m/lockstep_clock.h"

#include <array>
#include <bit>

namespace m100::hal {

void LockstepClock::sleep_until(core::TimePoint) {
  std::array<std::byte, sizeof(LockstepStep)> bytes{};
  std::size_t filled = 0;
  while (filled < bytes.size()) {
    filled += control_.read(std::span(bytes).subspan(filled)).value_or(0);
  }
  const auto step = std::bit_cast<LockstepStep>(bytes);
  now_ = core::TimePoint(core::Duration(step.now_us));
  order_ = step.order;
  while (autopilot_.received() != step.autopilot_bytes || pose_.received() != step.pose_bytes) {
  }
}

void LockstepClock::report(std::uint32_t tick_cycles, std::uint32_t stack_bytes) {
  const LockstepReport report{.autopilot_bytes = autopilot_.accepted(),
                              .pose_bytes = pose_.accepted(),
                              .tick_cycles = tick_cycles,
                              .stack_bytes = stack_bytes,
                              .lost_bytes = autopilot_.lost() + pose_.lost()};
  const auto bytes = std::bit_cast<std::array<std::byte, sizeof(report)>>(report);
  std::size_t taken = 0;
  while (taken < bytes.size()) {
    taken += control_.write(std::span(bytes).subspan(taken)).value_or(0);
  }
}

}  // namespace m100::hal
