// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/socket.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "hal/linux/descriptor.h"
#include "host_tests/sim/body/physics_program.h"
#include "host_tests/sim/body/sim_json.h"

namespace m100::sim {

/// Where a physics program listens.
struct PhysicsAddress {
  std::string host;
  std::uint16_t port = 0;
  PhysicsProgram* program = nullptr;  ///< the program, if it is ours; it outlives the link
};

/// The lockstep with a physics program over UDP: a servo packet out, one answer in.
///
/// A lost packet is sent again with the same frame count; an answer that came twice or late is told by its time stamp
/// and dropped. The first frame count is 0, which resets a program that has flown before. Everything else that is wrong
/// is a PhysicsError in one line: no answer, a program that ended or began anew, an answer that cannot be read, a time
/// step of 10 ms or more (ArduPilot's own limit: the attitude loop needs 100 Hz).
class PhysicsLink {
 public:
  struct Patience {
    std::chrono::milliseconds first{10000};  ///< for the first answer: the program may still be starting
    std::chrono::milliseconds later{5000};
    std::chrono::milliseconds again{1000};  ///< until the packet is sent again
  };
  /// @throws PhysicsError the address means nothing.
  PhysicsLink(const PhysicsAddress& address, std::uint16_t rate_hz, const Patience& patience);
  PhysicsLink(const PhysicsAddress& address, std::uint16_t rate_hz) : PhysicsLink(address, rate_hz, Patience{}) {}

  /// Sends the pulse widths, and waits for the state one step later.
  PhysicsAnswer exchange(const std::array<std::uint16_t, 16>& pulse_us);

  std::uint64_t dropped() const { return dropped_; }  ///< answers that came twice or late

 private:
  using Clock = std::chrono::steady_clock;
  [[noreturn]] void fail(const std::string& what) const;
  void send(const ServoPacket& packet);
  std::optional<PhysicsAnswer> receive(std::chrono::milliseconds at_most);
  PhysicsAnswer read(std::string_view datagram) const;
  void drop_waiting();
  bool is_new(const PhysicsAnswer& answer);
  void check_program();

  PhysicsAddress address_;
  std::string name_;
  Patience patience_;
  hal::Descriptor socket_;
  sockaddr_storage to_{};
  socklen_t to_size_ = 0;
  ServoPacket packet_;
  std::optional<double> last_s_;  ///< time stamp of the last answer
  bool refused_ = false;          ///< nothing listens at the port yet
  std::uint64_t dropped_ = 0;
};

}  // namespace m100::sim
