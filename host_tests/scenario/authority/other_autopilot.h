// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/mock/manual_clock.h"
#include "hal/mock/uart_pair.h"
#include "host_tests/sim/autopilot/n1_autopilot.h"
#include "host_tests/sim/world/still_vehicle.h"

namespace m100::authority {

/// Another aircraft at the same port: a complete autopilot in mode F, which grants every request for control.
class OtherAutopilot {
 public:
  OtherAutopilot(std::uint32_t baud, core::TimePoint plugged_in)
      : plugged_in_(plugged_in), line_(clock_, baud), autopilot_(line_.b(), vehicle_, {}) {
    autopilot_.on_event([this](const sim::N1Event& event) {
      was_asked_ += event.what == "received" && event.name == "obtain_control" ? 1U : 0U;
    });
  }

  /// Feeds the client's bytes. @returns the autopilot's bytes until now.
  std::vector<std::byte> talk(std::span<const std::byte> said, core::TimePoint now) {
    (void)line_.a().write(said);
    for (; clock_.now().time_since_epoch() < now - plugged_in_; clock_.advance(sim::N1Autopilot::kTick)) {
      autopilot_.advance(clock_.now());
    }
    std::vector<std::byte> answer(kMaxBytes);
    answer.resize(line_.a().read(answer).value_or(0));
    return answer;
  }

  /// Whether the client's start-up has succeeded with this autopilot.
  bool activated() const { return autopilot_.activated(); }
  std::uint32_t requests_for_control() const { return was_asked_; }

 private:
  static constexpr std::size_t kMaxBytes = 4096;

  core::TimePoint plugged_in_;
  hal::ManualClock clock_;
  hal::UartPair line_;
  sim::StillVehicle vehicle_;
  sim::N1Autopilot autopilot_;
  std::uint32_t was_asked_ = 0;
};

}  // namespace m100::authority
