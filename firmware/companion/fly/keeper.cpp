// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/keeper.h"

#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <new>
#include <stdexcept>

#include "firmware/companion/fly/keeper_channel.h"

namespace m100::companion {
namespace {

constexpr core::Duration kGoes = std::chrono::seconds(2);      ///< time-out after which a dismissed keeper is killed
constexpr core::Duration kComesUp = std::chrono::seconds(20);  ///< time-out for its start, as the machine may be busy

/// First sequence number of the farewells. Successive numbers differ, because the autopilot executes a number once per
/// session (protocol, section 5). They begin at the clock's value, because it may remember those of an earlier flight.
std::uint16_t first_sequence() { return static_cast<std::uint16_t>(monotonic_now().time_since_epoch().count()); }

Rounds make_rounds(const link::ChannelCommand& neutral, const protocol::Cipher* cipher) {
  const std::uint16_t first = first_sequence();
  const auto round = [&](int number) {
    return link::Farewell(neutral, cipher, static_cast<std::uint16_t>(first + number));
  };
  return {round(0), round(1), round(2), round(3)};
}

}  // namespace

Keeper::Keeper(const link::ChannelCommand& neutral, const protocol::Cipher* cipher, const std::string& port)
    : clock_(port) {
  void* const shared = mmap(nullptr, sizeof(KeeperBoard), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  std::array<int, 2> ends{-1, -1};
  if (shared == MAP_FAILED || socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw std::runtime_error("no room for the second process, which gives control back when this one dies");
  }
  board_ = new (shared) KeeperBoard;
  const Rounds rounds = make_rounds(neutral, cipher);
  process_ = fork();
  if (process_ < 0) {
    throw std::runtime_error("the second process, which gives control back when this one dies, cannot be started");
  }
  if (process_ == 0) {
    keep_watch(ends[1], rounds, *board_, clock_);
  }
  (void)close(ends[1]);
  socket_ = ends[0];
  if (!comes_up()) {
    (void)kill(process_, SIGKILL);
    (void)waitpid(process_, nullptr, 0);
    throw std::runtime_error(
        "the second process, which gives control back when this one dies, does not report that it runs");
  }
}

bool Keeper::comes_up() {
  pollfd words{.fd = socket_, .events = POLLIN, .revents = 0};
  for (const core::TimePoint until = monotonic_now() + kComesUp; monotonic_now() < until;) {
    (void)poll(&words, 1, milliseconds(kLook));
    const Word word = receive_word(socket_);
    if (word.letter != 0) {
      return word.letter == kStands;
    }
  }
  return false;
}

Keeper::~Keeper() {
  if (board_->beats.load() == 0) {
    dismiss();
  }
  (void)close(socket_);
  if (process_ > 0) {
    (void)waitpid(process_, nullptr, 0);
  }
  (void)munmap(board_, sizeof(KeeperBoard));
}

void Keeper::hold(int descriptor, std::uint32_t openings) {
  if ((descriptor != held_ || openings != openings_) &&
      send_word(socket_, descriptor >= 0 ? kPort : kNoPort, descriptor)) {
    held_ = descriptor;
    openings_ = openings;
  }
}

bool Keeper::beat(bool in_control) {
  board_->in_control.store(in_control ? 1 : 0);
  std::uint32_t beats = board_->beats.load();
  const std::uint32_t next = (beats + 1) & ~KeeperBoard::kSpoken;
  // The exchange can fail only because the keeper has set its bit; then the keeper does not write any more.
  if ((beats & KeeperBoard::kSpoken) == 0 && board_->beats.compare_exchange_strong(beats, next == 0 ? 1 : next)) {
    return true;
  }
  board_->beats.store(next == 0 ? 1 : next);
  return false;
}

bool Keeper::alive() {
  if (process_ > 0 && waitpid(process_, nullptr, WNOHANG) == process_) {
    process_ = -1;
  }
  return process_ > 0;
}

Keeper::Guard Keeper::guard(core::TimePoint now) {
  const std::uint32_t looks = board_->looks.load();
  if (looks != seen_looks_ || seen_at_ == core::TimePoint{}) {
    seen_looks_ = looks;
    seen_at_ = now;
  }
  if (now - seen_at_ < kHang) {
    return Guard::kStands;
  }
  return alive() ? Guard::kStandsStill : Guard::kDead;
}

void Keeper::dismiss() { end(kGo, kGoes); }

void Keeper::speak() { end(kSpeak, kGoes + static_cast<int>(kRounds) * kRepeat); }

void Keeper::end(char letter, core::Duration patience) {
  if (process_ <= 0) {
    return;
  }
  (void)send_word(socket_, letter, -1);
  for (core::TimePoint until = monotonic_now() + patience; alive() && monotonic_now() < until;) {
    if (clock_.is_simulated()) {
      clock_.sleep_until(clock_.now() +
                         std::chrono::milliseconds(1));  // otherwise simulated time would not advance for the keeper
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
