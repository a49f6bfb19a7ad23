// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "hal/clock.h"
#include "hal/linux/monotonic_clock.h"

namespace m100::hal {

// A simulated port is named "sim:SOCKET". Its bytes come over a Unix socket, and it carries time with it: the process
// that opens one lives in the time of the host behind the socket, which lets it pass as soon as every process in it
// sleeps. A flight then takes as long as its arithmetic does. A port of any other name has no clock but the machine's.
//
// Who connects says what for: eight bytes, {u32 purpose, u32 value} in the machine's byte order.
//   a port   kPort, baud   answered by one byte, 1 or 0 (somebody holds it); then bytes both ways
//   a clock  kClock, pid   answered by {i64 now}; then {i64 deadline} asks to sleep and {i64 now} ends it, microseconds
// The host hands bytes over before the {i64 now} that they belong to, and takes them before it lets time pass.

enum class SimulatedPurpose : std::uint32_t { kPort = 0x504D3031, kClock = 0x434D3031 };
struct SimulatedHello {
  SimulatedPurpose purpose;
  std::uint32_t value;
};

constexpr bool is_simulated(std::string_view port) { return port.substr(0, 4) == "sim:"; }

/// Opens a simulated port, non-blocking. @returns its descriptor; -1 with errno: EBUSY where another program holds it,
/// else why the host cannot be reached.
int open_simulated(const std::string& port, std::uint32_t baud);

/// The clock that goes with a port: the host's time for a simulated port, CLOCK_MONOTONIC for any other. Either counts
/// from the construction of the object. All clocks of a process share one connection to the host; a process that was
/// forked makes its own. Where the host is gone, simulated time goes on at the pace of the machine's clock.
class PortClock final : public Clock {
 public:
  explicit PortClock(const std::string& port);
  core::TimePoint now() override;
  void sleep_until(core::TimePoint deadline) override;
  bool is_simulated() const { return !host_.empty(); }

 private:
  MonotonicClock machine_;
  std::string host_;  ///< empty: the machine's clock
  core::Duration start_{0};
};

}  // namespace m100::hal
