// SPDX-License-Identifier: BSD-3-Clause
// The second process of a flight. It is a fork, so nothing here may use the heap, a lock or stdio.
#include "firmware/companion/backup/backup_monitor.h"

#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cerrno>

#include "firmware/companion/operator/terminal.h"

namespace m100::companion {
namespace {

constexpr int kPriority = 51;  ///< of SCHED_FIFO, if granted: one above the program, which may spin

class BackupMonitor {
 public:
  BackupMonitor(int socket, const Rounds& rounds, BackupSharedState& board, hal::PortClock& clock)
      : socket_(socket), rounds_(rounds), shared_(board), clock_(clock) {}

  [[noreturn]] void run() {
    detach();
    last_change_ = clock_.now();  // in simulated time, the clock waits for this process from here on
    (void)send_message(socket_, kReady, -1);
    while (true) {
      wait(BackupProcess::kPollInterval);
      handle(receive_message(socket_));
      check_heartbeat(clock_.now());
      shared_.polls.fetch_add(1);
    }
  }

 private:
  /// Least number of polls without a new heartbeat before the release: time for the program after a stall of the
  /// machine.
  static constexpr int kStallLooks = 4;
  /// 40 ms of promise R4 less the 20 ms between two polls, by which a heartbeat may be older than it seems.
  static constexpr core::Duration kMaxHeartbeatAge = std::chrono::milliseconds(40) - BackupProcess::kPollInterval;
  static constexpr core::Duration kWriteTimeout = std::chrono::milliseconds(50);

  void detach() const {
    (void)setsid();
    for (int number = 1; number < NSIG; ++number) {
      (void)signal(number, SIG_IGN);  // fails for those that cannot be ignored
    }
    (void)signal(SIGSEGV, SIG_DFL);
    (void)signal(SIGBUS, SIG_DFL);
    (void)prctl(PR_SET_NAME, "m100-backup");
    // All other inherited descriptors belong to the program; stderr stays open for the messages.
    const auto socket = static_cast<unsigned>(socket_);
    close_all(STDERR_FILENO + 1, socket - 1);
    close_all(socket + 1, ~0U);
    (void)close(STDIN_FILENO);
    (void)close(STDOUT_FILENO);
    const sched_param priority{.sched_priority = kPriority};
    (void)sched_setscheduler(0, SCHED_FIFO, &priority);
    (void)mlockall(MCL_CURRENT);
  }

  static void close_all(unsigned first, unsigned last) {
    if (first <= last && close_range(first, last, 0) != 0) {
      constexpr unsigned kMaxDescriptor = 1024;  // a kernel before 5.9
      for (unsigned number = first; number <= last && number < kMaxDescriptor; ++number) {
        (void)close(static_cast<int>(number));
      }
    }
  }

  /// Waits until a message comes or the time is over; in simulated time always until it is over.
  void wait(core::Duration time) {
    if (clock_.is_simulated()) {
      clock_.sleep_until(clock_.now() + time);
      return;
    }
    pollfd waiting{.fd = socket_, .events = POLLIN, .revents = 0};
    (void)poll(&waiting, 1, milliseconds(time));
  }

  void handle(const BackupMessage& word) {
    if (word.letter == kExit) {
      _exit(0);
    }
    if (word.letter == kPort || word.letter == kNoPort) {
      if (port_ >= 0) {
        (void)close(port_);
      }
      port_ = word.descriptor;
    }
    if (word.letter == kRelease) {
      release_and_exit("");
    }
    if (word.letter < 0) {
      release_and_exit("m100: the flying program ended unexpectedly; control was given back\n");
    }
  }

  [[noreturn]] void release_and_exit(const char* line) {
    // The neutral command is a control command: it is sent only if the last tick was just now and had control.
    const bool in_control =
        shared_.in_control.load() != 0 && (shared_.heartbeats.load() & BackupSharedState::kReleased) == 0;
    const bool just_now = clock_.now() - last_change_ <= kMaxHeartbeatAge;
    for (std::size_t round = 0; round < BackupProcess::kRounds; ++round) {
      send_release(round == 0 && in_control && just_now);
      if (round == 0) {
        write_nonblocking(STDERR_FILENO, line);
      }
      if (round + 1 < BackupProcess::kRounds) {
        pause();
      }
    }
    _exit(0);
  }

  /// Waits between two rounds at the end, when no message is expected any more.
  void pause() {
    if (clock_.is_simulated()) {
      clock_.sleep_until(clock_.now() + BackupProcess::kRoundInterval);
    } else {
      (void)poll(nullptr, 0, milliseconds(BackupProcess::kRoundInterval));
    }
  }

  void check_heartbeat(core::TimePoint now) {
    const std::uint32_t heartbeats = shared_.heartbeats.load();
    if (heartbeats != last_heartbeats_) {
      last_heartbeats_ = heartbeats;
      last_change_ = now;
      looks_ = 0;
      rounds_left_ = BackupProcess::kRounds;
      return;
    }
    ++looks_;
    const bool begun = (heartbeats & ~BackupSharedState::kReleased) != 0;
    if (!begun || rounds_left_ == 0 || looks_ < kStallLooks || now - last_change_ < BackupProcess::kHeartbeatTimeout ||
        now < next_round_) {
      return;
    }
    std::uint32_t expected = heartbeats;
    if (!shared_.heartbeats.compare_exchange_strong(expected, heartbeats | BackupSharedState::kReleased)) {
      return;  // a new heartbeat
    }
    last_heartbeats_ = heartbeats | BackupSharedState::kReleased;
    send_release(false);
    if (rounds_left_ == BackupProcess::kRounds) {
      write_nonblocking(STDERR_FILENO, "m100: the flying program does not answer; control was given back\n");
    }
    --rounds_left_;
    next_round_ = now + BackupProcess::kRoundInterval;
  }

  /// Sends the release sequence of the next round, as much of it as the line takes within kWriteTimeout.
  void send_release(bool with_neutral) {
    const link::ReleaseSequence& sequence = rounds_[next_++ % BackupProcess::kRounds];
    std::span<const std::byte> left = with_neutral ? sequence.bytes() : sequence.release_only();
    const core::TimePoint until = monotonic_now() + kWriteTimeout;
    while (port_ >= 0 && !left.empty() && monotonic_now() < until) {
      pollfd line{.fd = port_, .events = POLLOUT, .revents = 0};
      (void)poll(&line, 1, milliseconds(kWriteTimeout));
      const ssize_t count = write(port_, left.data(), left.size());
      if (count < 0 && errno != EAGAIN && errno != EINTR) {
        return;  // the port is gone
      }
      left = left.subspan(count > 0 ? static_cast<std::size_t>(count) : 0);
    }
  }

  int socket_;
  const Rounds& rounds_;
  BackupSharedState& shared_;
  hal::PortClock& clock_;
  int port_ = -1;
  std::size_t next_ = 0;
  std::uint32_t last_heartbeats_ = 0;
  core::TimePoint last_change_{};
  core::TimePoint next_round_{};
  int looks_ = 0;
  std::size_t rounds_left_ = BackupProcess::kRounds;
};

}  // namespace

void run_backup(int socket, const Rounds& rounds, BackupSharedState& board, hal::PortClock& clock) {
  BackupMonitor(socket, rounds, board, clock).run();
}

}  // namespace m100::companion
