// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/backup/backup_process.h"

#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <new>
#include <stdexcept>

#include "firmware/companion/backup/backup_channel.h"
#include "firmware/companion/backup/backup_monitor.h"

namespace m100::companion {
namespace {

constexpr core::Duration kGoes =
    std::chrono::seconds(2);  ///< time-out after which a dismissed backup process is killed
constexpr core::Duration kStartTimeout =
    std::chrono::seconds(20);  ///< time-out for its start, as the machine may be busy

/// Sequence number of the first round of release requests; each further round has the next number, because the
/// autopilot executes a number only once per session (protocol, section 5). The first is taken from the clock, because
/// the autopilot may still remember the numbers of an earlier flight.
std::uint16_t first_sequence() { return static_cast<std::uint16_t>(monotonic_now().time_since_epoch().count()); }

Rounds make_rounds(const link::ChannelCommand& neutral, const protocol::Cipher* cipher) {
  const std::uint16_t first = first_sequence();
  const auto round = [&](int number) {
    return link::ReleaseSequence(neutral, cipher, static_cast<std::uint16_t>(first + number));
  };
  return {round(0), round(1), round(2), round(3)};
}

}  // namespace

BackupProcess::BackupProcess(const link::ChannelCommand& neutral, const protocol::Cipher* cipher,
                             const std::string& port)
    : clock_(port) {
  void* const shared =
      mmap(nullptr, sizeof(BackupSharedState), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  std::array<int, 2> ends{-1, -1};
  if (shared == MAP_FAILED || socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw std::runtime_error("no room for the second process, which gives control back when this one dies");
  }
  shared_ = new (shared) BackupSharedState;
  const Rounds rounds = make_rounds(neutral, cipher);
  process_ = fork();
  if (process_ < 0) {
    throw std::runtime_error("the second process, which gives control back when this one dies, cannot be started");
  }
  if (process_ == 0) {
    run_backup(ends[1], rounds, *shared_, clock_);
  }
  (void)close(ends[1]);
  socket_ = ends[0];
  if (!wait_until_ready()) {
    (void)kill(process_, SIGKILL);
    (void)waitpid(process_, nullptr, 0);
    throw std::runtime_error(
        "the second process, which gives control back when this one dies, does not report that it runs");
  }
}

bool BackupProcess::wait_until_ready() {
  pollfd words{.fd = socket_, .events = POLLIN, .revents = 0};
  for (const core::TimePoint until = monotonic_now() + kStartTimeout; monotonic_now() < until;) {
    (void)poll(&words, 1, milliseconds(kPollInterval));
    const BackupMessage word = receive_message(socket_);
    if (word.letter != 0) {
      return word.letter == kReady;
    }
  }
  return false;
}

BackupProcess::~BackupProcess() {
  if (shared_->heartbeats.load() == 0) {
    dismiss();
  }
  (void)close(socket_);
  if (process_ > 0) {
    (void)waitpid(process_, nullptr, 0);
  }
  (void)munmap(shared_, sizeof(BackupSharedState));
}

void BackupProcess::set_port(int descriptor, std::uint32_t openings) {
  if ((descriptor != held_ || openings != openings_) &&
      send_message(socket_, descriptor >= 0 ? kPort : kNoPort, descriptor)) {
    held_ = descriptor;
    openings_ = openings;
  }
}

bool BackupProcess::heartbeat(bool in_control) {
  shared_->in_control.store(in_control ? 1 : 0);
  std::uint32_t heartbeats = shared_->heartbeats.load();
  const std::uint32_t next = (heartbeats + 1) & ~BackupSharedState::kReleased;
  // The exchange can fail only because the backup process has set kReleased; then that process does not write any more.
  if ((heartbeats & BackupSharedState::kReleased) == 0 &&
      shared_->heartbeats.compare_exchange_strong(heartbeats, next == 0 ? 1 : next)) {
    return true;
  }
  shared_->heartbeats.store(next == 0 ? 1 : next);
  return false;
}

bool BackupProcess::alive() {
  if (process_ > 0 && waitpid(process_, nullptr, WNOHANG) == process_) {
    process_ = -1;
  }
  return process_ > 0;
}

BackupProcess::State BackupProcess::state(core::TimePoint now) {
  const std::uint32_t polls = shared_->polls.load();
  if (polls != last_polls_ || seen_at_ == core::TimePoint{}) {
    last_polls_ = polls;
    seen_at_ = now;
  }
  if (now - seen_at_ < kHeartbeatTimeout) {
    return State::kReady;
  }
  return alive() ? State::kStalled : State::kDead;
}

void BackupProcess::dismiss() { end(kExit, kGoes); }

void BackupProcess::send_release() { end(kRelease, kGoes + static_cast<int>(kRounds) * kRoundInterval); }

void BackupProcess::end(char letter, core::Duration patience) {
  if (process_ <= 0) {
    return;
  }
  (void)send_message(socket_, letter, -1);
  for (core::TimePoint until = monotonic_now() + patience; alive() && monotonic_now() < until;) {
    if (clock_.is_simulated()) {
      clock_.sleep_until(clock_.now() + std::chrono::milliseconds(
                                            1));  // otherwise simulated time would not advance for the backup process
    }
    (void)poll(nullptr, 0, 1);  // its end takes real time, even in simulated time
  }
  if (process_ > 0) {  // it was stopped from outside
    (void)kill(process_, SIGKILL);
    (void)waitpid(process_, nullptr, 0);
    process_ = -1;
  }
}

}  // namespace m100::companion
