// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <string>
#include <thread>

#include "firmware/core/spsc_ring.h"
#include "protocol/mavlink/signature.h"

namespace m100::companion {

/// What a key has accepted, as text. Errors: UsageError naming file and line.
mavlink::ReplayMemory parse_replay_memory(const std::string& text, const std::string& name);
/// @param ahead added to every time of a stream: how far beyond what is known a later life shall refuse.
std::string text_of(const mavlink::ReplayMemory& memory, mavlink::SignatureTime ahead);

/// The newest time stamps that were accepted with a key, in a file beside it (KEY.accepted), so that what was recorded
/// before a restart is refused after it. A thread of its own writes it about once a second, kAhead further than it is,
/// so that a program that is killed refuses what it had accepted since; the end of the program writes what is.
class ReplayFile {
 public:
  static constexpr mavlink::SignatureTime kAhead = 3 * mavlink::kSignatureTicksPerSecond;

  /// Where the file of a key lies.
  static std::string beside(const std::string& key_file) { return key_file + ".accepted"; }
  /// Reads what is there; none is an empty one. Errors: UsageError, also where it cannot be written.
  explicit ReplayFile(const std::string& key_file);
  ~ReplayFile() { finish(); }
  ReplayFile(const ReplayFile&) = delete;
  ReplayFile& operator=(const ReplayFile&) = delete;

  /// What an earlier life has accepted.
  const mavlink::ReplayMemory& before() const { return before_; }
  void start();
  /// From the thread that flies: neither waits nor allocates. What finds no room is followed by something newer.
  void offer(const mavlink::ReplayMemory& memory) { (void)ring_.push(memory); }
  /// The last word, as it is. Says on stderr where the file takes no more.
  void finish(const mavlink::ReplayMemory& memory);

 private:
  void finish();
  /// The file anew, as a whole or not at all. @returns false: it could not be written.
  bool write(const mavlink::ReplayMemory& memory, mavlink::SignatureTime ahead);

  std::string path_;
  mavlink::ReplayMemory before_;
  core::SpscRing<mavlink::ReplayMemory, 4> ring_;
  std::atomic<bool> running_{true};
  std::thread writer_;
};

}  // namespace m100::companion
