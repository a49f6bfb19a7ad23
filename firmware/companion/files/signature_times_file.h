// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <thread>

#include "firmware/companion/files/text/file_error.h"
#include "firmware/core/spsc_ring.h"
#include "protocol/mavlink/signature.h"

namespace m100::companion {

/// Parses the text of a SignatureTimesFile (TOML), or of one of an earlier version. Errors: FileError.
mavlink::ReplayMemory parse_replay_memory(const std::string& text, const std::string& name);
/// The text of the file. @param ahead added to the time of every stream: a later run refuses time stamps up to there.
std::string text_of(const mavlink::ReplayMemory& memory, mavlink::SignatureTime ahead);

/// The newest time stamps that were accepted with a key, in a file beside it (KEY.accepted), so that frames recorded
/// before a restart are refused after it. A separate thread writes the file about once a second. It adds kAhead to the
/// times, so that a kill between two writes lets no frame pass again. At its end the program writes the exact times.
class SignatureTimesFile {
 public:
  static constexpr mavlink::SignatureTime kAhead = 3 * mavlink::kSignatureTicksPerSecond;

  /// The path of the file that belongs to a key.
  static std::string path_for(const std::string& key_file) { return key_file + ".accepted"; }
  /// Reads the file; a missing file counts as empty. Errors: FileError; UsageError if it cannot be written.
  explicit SignatureTimesFile(const std::string& key_file);
  SignatureTimesFile(const SignatureTimesFile&) = delete;
  SignatureTimesFile& operator=(const SignatureTimesFile&) = delete;

  /// The time stamps that earlier runs have accepted.
  const mavlink::ReplayMemory& accepted_before() const { return accepted_before_; }
  void start();
  /// Called by the thread that flies: neither waits nor allocates. What finds no room is skipped; newer times follow.
  void offer(const mavlink::ReplayMemory& memory) { (void)ring_.push(memory); }
  /// Writes the exact times at the end of the program. Prints a line on stderr if that fails.
  void finish(const mavlink::ReplayMemory& memory);

 private:
  /// Replaces the file atomically. @returns false: it could not be written.
  bool write(const mavlink::ReplayMemory& memory, mavlink::SignatureTime ahead);

  std::string path_;
  mavlink::ReplayMemory accepted_before_;
  core::SpscRing<mavlink::ReplayMemory, 4> ring_;
  std::jthread writer_;
};

}  // namespace m100::companion
