// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "firmware/core/time.h"

namespace m100::sim {

/// The far side of hal/linux/simulated_port.h: sockets that programs open as serial ports, and the time they live in.
///
/// Each socket is one end of a cable; who owns the host carries bytes from end to end, and may do with them what he
/// likes. Time goes to the earliest deadline of the programs that attend, they are woken one after the other in the
/// order in which they came, and nothing moves until each sleeps again: the same programs see the same bytes at the
/// same times, however busy the machine is. A program that ended is not waited for, nor is one that is suspended (told
/// so, or seen by its state in /proc). From one thread, but for stop().
class LockstepHost {
 public:
  using End = std::size_t;
  /// Bytes that wait for a program that does not read; what comes beyond is lost, as in a driver's buffer.
  static constexpr std::size_t kWaitingBytes = 4096;

  LockstepHost() = default;
  ~LockstepHost();
  LockstepHost(const LockstepHost&) = delete;
  LockstepHost& operator=(const LockstepHost&) = delete;

  /// Makes a socket. @throws std::runtime_error
  End add_end(const std::string& path);
  /// The adapter is pulled out: who holds the end sees it hang up, and it cannot be opened.
  void unplug(End end);
  void plug_in(End end);
  bool connected(End end) const { return ends_[end].descriptor >= 0; }
  /// The rate that the program at the end set; 0: nobody is there.
  std::uint32_t baud(End end) const { return ends_[end].baud; }

  /// What the program at the end wrote since the call before.
  std::vector<std::byte> take(End end);
  /// Bytes for the program at the end; it has them when it wakes next.
  void give(End end, std::span<const std::byte> bytes);

  core::TimePoint now() const { return now_; }
  /// Lets time pass to the earliest deadline, at most to `until`, and wakes whose deadline it is.
  void advance(core::TimePoint until);
  /// Time stands still until the condition holds. @returns false: it did not within so many real seconds.
  bool wait_for(const std::function<bool()>& condition, double at_most_s);
  /// How many processes attend, and whether this one does.
  std::size_t attendants() const { return attendants_.size(); }
  bool attends(pid_t process) const;
  /// Time passes without this process until it is resumed; it then finds itself late.
  void suspend(pid_t process);
  void resume(pid_t process);
  /// Lets every call return soon. From any thread, or a signal handler.
  void stop() { stopped_ = true; }
  bool stopped() const { return stopped_; }

 private:
  struct EndState {
    std::string path;
    int listening = -1;
    int descriptor = -1;
    pid_t process = -1;
    std::uint32_t baud = 0;
    std::vector<std::byte> written{};
    std::vector<std::byte> waiting{};
  };
  struct Attendant {
    int descriptor = -1;
    pid_t process = -1;
    std::int64_t deadline_us = 0;
    bool asleep = false;
    bool seen_stopped = false;
  };

  void listen(EndState& end);
  void hang_up(EndState& end);
  void receive(EndState& end);
  void welcome(EndState& end);
  void hear(Attendant& attendant);
  void hand_over(pid_t process);
  void wake(std::size_t attendant);
  void await_sleep(std::size_t attendant);
  void await_newcomers();
  void service(int patience_ms);
  void drop_the_gone();

  std::vector<EndState> ends_;
  std::vector<Attendant> attendants_;
  std::vector<pid_t> suspended_;
  core::TimePoint now_{};
  std::atomic<bool> stopped_ = false;
};

}  // namespace m100::sim
