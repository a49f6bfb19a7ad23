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

/// The host side of hal/linux/simulated_port.h: sockets that programs open as serial ports, and their simulated time.
///
/// Each socket is one end of a cable. The owner of the host carries bytes from end to end, and may change them. The
/// host advances time to the earliest deadline of the attached programs, wakes them one after the other in the order in
/// which they connected, and waits until each sleeps again. The same programs therefore see the same bytes at the same
/// times, however busy the machine is. The host does not wait for a program that ended or is suspended (by suspend(),
/// or by its state in /proc). Use it from one thread, except stop().
class LockstepHost {
 public:
  using End = std::size_t;
  /// Bytes that wait for a program that does not read; further bytes are lost, as in a driver's buffer.
  static constexpr std::size_t kWaitingBytes = 4096;

  LockstepHost() = default;
  ~LockstepHost();
  LockstepHost(const LockstepHost&) = delete;
  LockstepHost& operator=(const LockstepHost&) = delete;

  /// Makes a socket. @throws std::runtime_error
  End add_end(const std::string& path);
  /// Unplugs the adapter: the program that holds the end sees a hang-up, and the end cannot be opened.
  void unplug(End end);
  void plug_in(End end);
  bool connected(End end) const { return ends_[end].descriptor >= 0; }
  /// The baud rate that the program at the end has set; 0: no program is connected.
  std::uint32_t baud(End end) const { return ends_[end].baud; }

  /// The bytes that the program at the end has written since the previous call.
  std::vector<std::byte> take(End end);
  /// Bytes for the program at the end; it can read them when it wakes next.
  void give(End end, std::span<const std::byte> bytes);

  core::TimePoint now() const { return now_; }
  /// Advances time to the earliest deadline, at most to `until`, and wakes the programs with that deadline.
  void advance(core::TimePoint until);
  /// Stops time until the condition holds. @returns false: it did not hold within so many real seconds.
  bool wait_for(const std::function<bool()>& condition, double at_most_s);
  /// How many processes are attached, and whether this one is.
  std::size_t attached_count() const { return programs_.size(); }
  bool is_attached(pid_t process) const;
  /// Advances time without this process until it is resumed; it is then late.
  void suspend(pid_t process);
  void resume(pid_t process);
  /// Makes every call return soon. From any thread, or a signal handler.
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
  struct AttachedProgram {
    int descriptor = -1;
    pid_t process = -1;
    std::int64_t deadline_us = 0;
    bool asleep = false;
    bool seen_stopped = false;
  };

  void listen(EndState& end);
  void hang_up(EndState& end);
  void receive(EndState& end);
  void accept_end(EndState& end);
  void receive(AttachedProgram& program);
  void hand_over(pid_t process);
  void wake(std::size_t program);
  void await_sleep(std::size_t program);
  void wait_for_newcomers();
  void service(int patience_ms);
  void drop_ended();

  std::vector<EndState> ends_;
  std::vector<AttachedProgram> programs_;
  std::vector<pid_t> suspended_;
  core::TimePoint now_{};
  std::atomic<bool> stopped_ = false;
};

}  // namespace m100::sim
