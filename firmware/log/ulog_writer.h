// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/core/status.h"
#include "firmware/core/time.h"
#include "firmware/log/ring.h"

namespace m100::log {

inline constexpr std::size_t kLongestNote_bytes = 60000;  ///< a message's size has 16 bits

/// Information that a reader needs besides the records, for instance the vehicle file.
struct Note {
  std::string_view key;
  std::string_view text;  ///< a longer one than kLongestNote_bytes is left out, because a part of a file is useless
};

/// Writes ULog (version 1, docs.px4.io/main/en/dev_log/ulog_file_format.html) into a ring: the bytes as they leave the
/// ring are the file. Never waits; a message that does not fit is dropped as a whole and counted.
///
/// Cost: one copy of the record per append. R6: the bytes depend on the arguments only.
class UlogWriter {
 public:
  explicit UlogWriter(Ring& ring) : ring_(ring) {}

  /// Writes the file's header, formats, notes and subscriptions. Once, before the first append.
  /// @param formats "name:type field;type field;" of each record; its place in the list is the record's id.
  /// @returns kResourceExhausted: the ring is too small for them, or a note is too long, which is then left out.
  core::Status begin(core::TimePoint now, std::span<const std::string_view> formats, std::span<const Note> notes);

  /// A record of the format with this id, as its bytes are in memory: no padding, the time stamp first.
  void append(std::uint16_t id, std::span<const std::byte> record);
  /// A line of text with its time (ULog's logged string, level info), cut at 60 000 bytes.
  void append(core::TimePoint now, std::string_view text);

  std::uint32_t dropped() const { return ring_.dropped(); }

 private:
  bool message(char type, std::span<const std::byte> head, std::span<const std::byte> body);
  bool note(const Note& note);

  Ring& ring_;
};

}  // namespace m100::log
