// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "firmware/companion/backup/backup_process.h"

namespace m100::companion {

/// The memory that the two processes share.
struct BackupSharedState {
  static constexpr std::uint32_t kReleased = 1U << 31U;
  /// Number of heartbeats. The bit kReleased is set when the backup process decides to send, until the next heartbeat.
  std::atomic<std::uint32_t> heartbeats{0};
  std::atomic<std::uint32_t> in_control{0};
  std::atomic<std::uint32_t> polls{0};  ///< of the backup process so far: they show that it runs
};
static_assert(std::atomic<std::uint32_t>::is_always_lock_free, "a lock could die with the program");

// Messages from the flying program over the socket, one letter each.
inline constexpr char kExit = 'g';     ///< end without sending
inline constexpr char kRelease = 's';  ///< send the release sequence, then end
inline constexpr char kPort = 'p';     ///< comes with a descriptor
inline constexpr char kNoPort = 'n';   ///< the port is closed

/// The backup process's one message: it runs, and sends from now on if the program dies.
inline constexpr char kReady = 'k';

/// Never waits. @param descriptor -1: none. @returns false: the other side takes nothing now, or has ended.
bool send_message(int socket, char letter, int descriptor);

/// A message from the other process.
struct BackupMessage {
  int letter = 0;  ///< 0: no message; -1: that process has ended
  int descriptor = -1;
};

/// Never waits.
BackupMessage receive_message(int socket);

core::TimePoint monotonic_now();
inline int milliseconds(core::Duration duration) { return static_cast<int>(duration.count() / 1000); }

/// One release sequence for each round, each with sequence numbers of its own.
using Rounds = std::array<link::ReleaseSequence, BackupProcess::kRounds>;

}  // namespace m100::companion
