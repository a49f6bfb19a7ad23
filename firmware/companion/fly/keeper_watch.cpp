// SPDX-License-Identifier: BSD-3-Clause
// The second process of a flight. It is a fork, so nothing here may use the heap, a lock or stdio.
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cerrno>

#include "firmware/companion/fly/keeper_channel.h"
#include "firmware/companion/fly/screen.h"

namespace m100::companion {
namespace {

constexpr int kPriority = 51;  ///< of SCHED_FIFO, if granted: one above the program, which may spin

class Watch {
 public:
  Watch(int socket, const Rounds& rounds, KeeperBoard& board, hal::PortClock& clock)
      : socket_(socket), rounds_(rounds), board_(board), clock_(clock) {}

  [[noreturn]] void keep() {
    stand_apart();
    last_change_ = clock_.now();  // in simulated time, the clock waits for this process from here on
    (void)send_word(socket_, kStands, -1);
    while (true) {
      rest(Keeper::kLook);
      obey(receive_word(socket_));
      look(clock_.now());
      board_.looks.fetch_add(1);
    }
  }

 private:
  /// A stall of the whole machine ends for both processes at once: the program gets a few looks to send a heartbeat.
  static constexpr int kLooks = 4;
  /// 40 ms of promise R4 less the 20 ms between two looks, by which a heartbeat may be older than it seems.
  static constexpr core::Duration kOneCommand = std::chrono::milliseconds(40) - Keeper::kLook;
  static constexpr core::Duration kLineTakes = std::chrono::milliseconds(50);

  void stand_apart() const {
    (void)setsid();
    for (int number = 1; number < NSIG; ++number) {
      (void)signal(number, SIG_IGN);  // fails for those that cannot be ignored
    }
    (void)signal(SIGSEGV, SIG_DFL);
    (void)signal(SIGBUS, SIG_DFL);
    (void)prctl(PR_SET_NAME, "m100-keeper");
    // All other inherited descriptors belong to the program; stderr stays open for one possible line.
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
      constexpr unsigned kMost = 1024;  // a kernel before 5.9
      for (unsigned number = first; number <= last && number < kMost; ++number) {
        (void)close(static_cast<int>(number));
      }
    }
  }

  /// Waits until a message comes or the time is over.
  void rest(core::Duration time) {
    if (clock_.is_simulated()) {
      clock_.sleep_until(clock_.now() + time);
      return;
    }
    pollfd waiting{.fd = socket_, .events = POLLIN, .revents = 0};
    (void)poll(&waiting, 1, milliseconds(time));
  }

  void obey(const Word& word) {
    if (word.letter == kGo) {
      _exit(0);
    }
    if (word.letter == kPort || word.letter == kNoPort) {
      if (port_ >= 0) {
        (void)close(port_);
      }
      port_ = word.descriptor;
    }
    if (word.letter == kSpeak) {
      speak_and_end("");
    }
    if (word.letter < 0) {
      speak_and_end("m100: the flying program ended unexpectedly; control was given back\n");
    }
  }

  [[noreturn]] void speak_and_end(const char* line) {
    // The neutral command is a control command: it is sent only while the last tick's view of control may be valid.
    const bool in_control = board_.in_control.load() != 0 && (board_.beats.load() & KeeperBoard::kSpoken) == 0;
    const bool just_now = clock_.now() - last_change_ <= kOneCommand;
    for (std::size_t round = 0; round < Keeper::kRounds; ++round) {
      speak(round == 0 && in_control && just_now);
      if (round == 0) {
        write_now(STDERR_FILENO, line);
      }
      if (round + 1 < Keeper::kRounds) {
        pause();
      }
    }
    _exit(0);
  }

  /// Waits between two rounds at the end, when no message is expected any more.
  void pause() {
    if (clock_.is_simulated()) {
      clock_.sleep_until(clock_.now() + Keeper::kRepeat);
    } else {
      (void)poll(nullptr, 0, milliseconds(Keeper::kRepeat));
    }
  }

  void look(core::TimePoint now) {
    const std::uint32_t beats = board_.beats.load();
    if (beats != last_beats_) {
      last_beats_ = beats;
      last_change_ = now;
      looks_ = 0;
      rounds_left_ = Keeper::kRounds;
      return;
    }
    ++looks_;
    const bool begun = (beats & ~KeeperBoard::kSpoken) != 0;
    if (!begun || rounds_left_ == 0 || looks_ < kLooks || now - last_change_ < Keeper::kHang || now < next_round_) {
      return;
    }
    std::uint32_t expected = beats;
    if (!board_.beats.compare_exchange_strong(expected, beats | KeeperBoard::kSpoken)) {
      return;  // a new heartbeat
    }
    last_beats_ = beats | KeeperBoard::kSpoken;
    speak(false);
    if (rounds_left_ == Keeper::kRounds) {
      write_now(STDERR_FILENO, "m100: the flying program does not answer; control was given back\n");
    }
    --rounds_left_;
    next_round_ = now + Keeper::kRepeat;
  }

  /// Sends one round, as much as the line takes.
  void speak(bool with_neutral) {
    const link::Farewell& words = rounds_[next_++ % Keeper::kRounds];
    std::span<const std::byte> left = with_neutral ? words.bytes() : words.giving_back();
    const core::TimePoint until = monotonic_now() + kLineTakes;
    while (port_ >= 0 && !left.empty() && monotonic_now() < until) {
      pollfd line{.fd = port_, .events = POLLOUT, .revents = 0};
      (void)poll(&line, 1, milliseconds(kLineTakes));
      const ssize_t count = write(port_, left.data(), left.size());
      if (count < 0 && errno != EAGAIN && errno != EINTR) {
        return;  // the port is gone
      }
      left = left.subspan(count > 0 ? static_cast<std::size_t>(count) : 0);
    }
  }

  int socket_;
  const Rounds& rounds_;
  KeeperBoard& board_;
  hal::PortClock& clock_;
  int port_ = -1;
  std::size_t next_ = 0;
  std::uint32_t last_beats_ = 0;
  core::TimePoint last_change_{};
  core::TimePoint next_round_{};
  int looks_ = 0;
  std::size_t rounds_left_ = Keeper::kRounds;
};

}  // namespace

void keep_watch(int socket, const Rounds& rounds, KeeperBoard& board, hal::PortClock& clock) {
  Watch(socket, rounds, board, clock).keep();
}

}  // namespace m100::companion
