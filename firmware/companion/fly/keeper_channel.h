// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "firmware/companion/fly/keeper.h"

namespace m100::companion {

/// What the two processes share.
struct KeeperBoard {
  static constexpr std::uint32_t kSpoken = 1U << 31U;
  /// Beats so far, and kSpoken from when the keeper decides to speak until the program has noticed it.
  std::atomic<std::uint32_t> beats{0};
  std::atomic<std::uint32_t> in_control{0};
  std::atomic<std::uint32_t> looks{0};  ///< of the keeper so far: it is alive, and runs
};
static_assert(std::atomic<std::uint32_t>::is_always_lock_free, "a lock could die with the program");

// What the flying program says over the socket, a letter at a time.
inline constexpr char kGo = 'g';
inline constexpr char kSpeak = 's';   ///< and go
inline constexpr char kPort = 'p';    ///< comes with a descriptor
inline constexpr char kNoPort = 'n';  ///< the port is closed

/// What the keeper says, once: it stands, and would speak if the program died now.
inline constexpr char kStands = 'k';

/// Never waits. @returns false: the other side takes nothing now, or is no more.
bool send_word(int socket, char letter, int descriptor);

/// What the program said: 0 nothing, -1 it is no more.
struct Word {
  int letter = 0;
  int descriptor = -1;
};

/// Never waits.
Word receive_word(int socket);

core::TimePoint monotonic_now();
inline int milliseconds(core::Duration duration) { return static_cast<int>(duration.count() / 1000); }

/// The farewell as often as it is said, each time with sequence numbers of its own.
using Rounds = std::array<link::Farewell, Keeper::kRounds>;

/// The second process from its first instruction to its last.
[[noreturn]] void keep_watch(int socket, const Rounds& rounds, KeeperBoard& board, hal::PortClock& clock);

}  // namespace m100::companion
