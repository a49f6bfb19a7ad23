// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/telemetry/telemetry_clock.h"

namespace m100::link {

TelemetryClock::Step TelemetryClock::step_of(const Mark& from, const Mark& to) {
  // Signed, so that the wrap of the counter is a step of one tick.
  const core::Duration stepped = static_cast<std::int32_t>(to.ticks - from.ticks) * kTick;
  if (stepped > to.latest - from.earliest + kJump || stepped < -kJump) {
    return Step::kJump;
  }
  if (stepped <= core::Duration{0}) {
    return Step::kBack;
  }
  return stepped < to.earliest - from.latest - kJump ? Step::kJump : Step::kOnwards;
}

TelemetryClock::Verdict TelemetryClock::update(std::uint32_t ticks, core::TimePoint earliest, core::TimePoint latest) {
  const Mark now{.known = true, .ticks = ticks, .earliest = earliest, .latest = latest};
  const Step step = trusted_.known ? step_of(trusted_, now) : Step::kOnwards;
  if (step == Step::kOnwards) {
    trusted_ = now;
    after_jump_.known = false;  // the package that jumped was an old one
    return {.is_new = true};
  }
  if (step == Step::kBack) {
    return {};
  }
  const Step second = after_jump_.known ? step_of(after_jump_, now) : Step::kJump;
  if (second == Step::kOnwards) {
    trusted_ = now;
    after_jump_.known = false;
    return {.is_new = true};
  }
  if (second == Step::kJump) {
    after_jump_ = now;
  }
  return {.restarted = second == Step::kJump};
}

}  // namespace m100::link
