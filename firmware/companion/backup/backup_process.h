// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

#include "firmware/link/release_sequence.h"
#include "hal/linux/simulated_port.h"

namespace m100::companion {

struct BackupSharedState;

/// The second process of a flight (promise R15). It holds the port and a ready-made release sequence. It sends the
/// sequence when the flying program has died without giving control back, or has sent no heartbeat for
/// kHeartbeatTimeout. It allocates nothing and reads nothing from the port.
///
/// It is forked early, before there are threads. It has a session of its own and ignores every signal that can be
/// ignored but SIGSEGV and SIGBUS, so Ctrl-C, a closed terminal and `kill 0` do not end it. After the death of the
/// program it ends with its last round.
///
/// Its decision to send and the program's heartbeats share one atomic word. After the decision the next heartbeat()
/// fails, and a heartbeat() that succeeded is valid for kHeartbeatTimeout. So the two never send at the same time.
class BackupProcess {
 public:
  static constexpr core::Duration kHeartbeatTimeout =
      std::chrono::milliseconds(700);  ///< without a heartbeat, after the first one
  static constexpr core::Duration kPollInterval =
      std::chrono::milliseconds(20);  ///< between two polls of the heartbeats
  /// Between two rounds, of two releases each: promise R4, at most five times a second.
  static constexpr core::Duration kRoundInterval = std::chrono::milliseconds(500);
  static constexpr std::size_t kRounds =
      4;  ///< of the release sequence, because the line may be bad and answers are not read

  /// Starts the second process and waits until it reports that it runs: control that is requested afterwards is given
  /// back whenever this program dies. @param neutral command of the channel in use. @param cipher null: plain.
  /// Errors: std::runtime_error if the system has no room for a process, or the process does not report: nothing flies.
  /// @param port whose clock is used; a simulated port has its own.
  BackupProcess(const link::ChannelCommand& neutral, const protocol::Cipher* cipher, const std::string& port = "");
  /// If the backup process has not been ended yet: dismisses it if there was no heartbeat; otherwise an exception is
  /// the cause, and the backup process sends its release sequence.
  ~BackupProcess();
  BackupProcess(const BackupProcess&) = delete;
  BackupProcess& operator=(const BackupProcess&) = delete;

  /// Passes the port's present descriptor to the backup process, each tick; -1: closed. The backup process closes a
  /// port that was unplugged, so that it can return under its name. No heap; costs a system call when something has
  /// changed.
  /// @param openings SerialPort::openings(), which distinguishes two ports with the same descriptor.
  void set_port(int descriptor, std::uint32_t openings);

  /// The heartbeat, each tick, before anything is sent. @param in_control control is ours.
  /// @returns false, once: the backup process has given control back since the last heartbeat: do not use control.
  bool heartbeat(bool in_control);

  /// False: the backup process has ended (it is reaped then), so nobody would give control back.
  bool alive();

  enum class State : std::uint8_t { kReady, kStalled, kDead };
  /// Each tick: whether the backup process would send if this program died now (kReady). It would not if it has not
  /// polled for kHeartbeatTimeout, because it is stopped, gets no processor time (kStalled), or has ended (kDead).
  State state(core::TimePoint now);

  /// The flight is over and control is back: the backup process ends. Waits for its end, and kills it after 2 s.
  void dismiss();

  /// The flight is over, but control may still be ours, or may be granted later: the backup process sends its rounds
  /// and ends. Waits for its end, and kills it after 4 s.
  void send_release();

  pid_t process() const { return process_; }

 private:
  bool wait_until_ready();
  void end(char letter, core::Duration patience);

  hal::PortClock clock_;
  BackupSharedState* shared_ = nullptr;
  int socket_ = -1;
  pid_t process_ = -1;
  int held_ = -1;
  std::uint32_t openings_ = 0;
  std::uint32_t last_polls_ = 0;
  core::TimePoint seen_at_{};
};

}  // namespace m100::companion
