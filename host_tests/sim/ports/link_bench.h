// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "firmware/link/serial_link.h"
#include "hal/mock/manual_clock.h"
#include "hal/mock/uart_pair.h"
#include "host_tests/sim/autopilot/n1_autopilot.h"
#include "host_tests/sim/world/still_vehicle.h"

namespace m100::sim {

/// A test bench: the link program at one end of a mock cable, the emulated autopilot at the other, and a manual clock.
/// The client ticks every 10 ms, sends a neutral command whenever it may, and records when commands left.
class LinkBench {
 public:
  struct Options {
    link::LinkConfig link;
    N1Config autopilot;
    std::uint32_t baud = 230400;
    std::uint64_t seed = 1;
    link::ByteTap* tap = nullptr;                                  ///< sees the bytes of the link
    std::function<hal::Uart&(hal::Uart&)> line = std::identity{};  ///< what the link sees of its end of the cable
  };
  static Options over(link::Channel channel) {
    Options options;
    options.link.channel.channel = channel;
    return options;
  }

  explicit LinkBench(const Options& options)
      : pair_(clock, options.baud, options.seed),
        autopilot(pair_.b(), vehicle, options.autopilot),
        link(options.line(pair_.a()), with_baud(options), options.tap),
        channel_(options.link.channel.channel) {}

  /// One client tick of 10 ms.
  void tick() {
    for (int i = 0; i < 4; ++i) {
      clock.advance(N1Autopilot::kTick);
      autopilot.advance(clock.now());
    }
    link.receive(clock.now());
    if (commanding) {
      last_status = link.send(command(), clock.now());
      if (last_status == core::Status::kOk) {
        sent_at.push_back(clock.now());
      }
    }
  }
  void run(core::Duration time) {
    for (const core::TimePoint end = clock.now() + time; clock.now() < end;) {
      tick();
    }
  }
  /// @returns false: the condition did not become true in time.
  bool run_until(const std::function<bool()>& condition, core::Duration at_most) {
    for (const core::TimePoint end = clock.now() + at_most; clock.now() < end;) {
      tick();
      if (condition()) {
        return true;
      }
    }
    return false;
  }
  bool run_until(safety::AuthorityStage stage, core::Duration at_most = std::chrono::seconds(20)) {
    return run_until([&] { return link.authority().stage == stage; }, at_most);
  }
  /// Goes from start-up to control, as an operator does.
  bool take_control() {
    const bool ready = run_until(safety::AuthorityStage::kReady);
    link.request_control(clock.now());
    return ready && run_until(safety::AuthorityStage::kInControl);
  }
  link::ChannelCommand command() const {
    return channel_ == link::Channel::kVirtualRc ? link::ChannelCommand(vrc::Sticks{})
                                                 : link::ChannelCommand(ctl::Command<double>{});
  }
  hal::UartPair& cable() { return pair_; }

  hal::ManualClock clock;
  StillVehicle vehicle;

 private:
  static link::LinkConfig with_baud(const Options& options) {
    link::LinkConfig link = options.link;
    link.baud = options.baud;
    return link;
  }
  hal::UartPair pair_;

 public:
  N1Autopilot autopilot;
  link::SerialLink link;
  bool commanding = true;
  core::Status last_status = core::Status::kOk;
  std::vector<core::TimePoint> sent_at;

 private:
  link::Channel channel_;
};

}  // namespace m100::sim
