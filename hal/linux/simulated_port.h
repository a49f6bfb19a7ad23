// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "hal/clock.h"
#include "hal/linux/monotonic_clock.h"

namespace m100::hal {

// A simulated port is named "sim:SOCKET". Its bytes come over a Unix socket, and it carries simulated time: a process
// that opens one uses the clock of the host behind the socket. The host advances time as soon as every attached process
// sleeps, so a flight takes only as long as its computation. A port of any other name uses the machine's clock.
//
// A connection begins with its purpose: eight bytes, {u32 purpose, u32 value} in the machine's byte order.
//   a port   kPort, baud   answered by one byte, 1 or 0 (already in use); then bytes in both directions
//   a clock  kClock, pid   answered by {i64 now}; then {i64 deadline} requests a sleep, {i64 now} ends it, microseconds
// The host delivers bytes before the {i64 now} that they belong to, and collects them before it advances time.

enum class SimulatedPurpose : std::uint32_t { kPort = 0x504D3031, kClock = 0x434D3031 };
struct SimulatedHello {
  SimulatedPurpose purpose;
  std::uint32_t value;
};

constexpr bool is_simulated(std::string_view port) { return port.substr(0, 4) == "sim:"; }

/// Opens a simulated port, non-blocking. @returns its descriptor; -1 with errno: EBUSY if another program holds it or
/// the host does not answer, otherwise the reason why the host cannot be reached.
int open_simulated(const std::string& port, std::uint32_t baud);

/// The clock of a port: the host's time for a simulated port, CLOCK_MONOTONIC for any other. Both count from the
/// construction of the object. All clocks of a process share one connection to the host; a forked process makes its
/// own. If the host disconnects, only sleeps advance the time, and they take real time.
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
