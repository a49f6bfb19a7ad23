// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/dji/frame_parser.h"

#include <algorithm>
#include <cstring>

#include "firmware/core/assert.h"
#include "protocol/bytes.h"
#include "protocol/crc.h"

namespace m100::protocol {
namespace {

constexpr std::size_t kCrc16At = kHeaderBytes - 2;
constexpr std::size_t kTailBytes = kHeaderBytes - 1;  // kept of a delivered frame: one byte less than a header

std::size_t length_of(const std::byte* at) { return load<std::uint16_t>(at + 1) & kMaxFrameBytes; }

FrameHeader read_header(const std::byte* at) {
  const auto flags = load<std::uint8_t>(at + 3);
  const auto cipher = load<std::uint8_t>(at + 4);
  return {.length_bytes = static_cast<std::uint16_t>(length_of(at)),
          .session = static_cast<std::uint8_t>(flags & 0x1FU),
          .is_ack = (flags & 0x20U) != 0,
          .encryption = static_cast<std::uint8_t>(cipher >> 5U),
          .padding_bytes = static_cast<std::uint8_t>(cipher & 0x1FU),
          .sequence = load<std::uint16_t>(at + 8)};
}

/// Whether VER, RES0 and RES1, bits of bytes 2, 3 and 5 to 7, are zero.
bool reserved_bits_are_zero(const std::byte* at) {
  return (load<std::uint32_t>(at) & 0xC0FC0000U) == 0 && load<std::uint32_t>(at + 4) <= 0xFFU;
}

/// Whether the filler fits into DATA, and encrypted DATA is whole cipher blocks.
bool padding_makes_sense(const std::byte* at, std::size_t length) {
  const auto cipher = load<std::uint8_t>(at + 4);
  const std::size_t data_bytes = length > kHeaderBytes ? length - kFrameOverheadBytes : 0;
  const bool encrypted = cipher >= 0x20;
  return cipher == 0 || ((cipher & 0x1FU) <= data_bytes && (!encrypted || data_bytes % kCipherBlockBytes == 0));
}

}  // namespace

std::size_t FrameParser::push(std::span<const std::byte> bytes) {
  if (begin_ > 0 && buffer_.size() - end_ < bytes.size()) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    base_ += begin_;
    end_ -= begin_;
    delivered_ = delivered_ > begin_ ? delivered_ - begin_ : 0;
    begin_ = 0;
  }
  const std::size_t count = std::min(bytes.size(), buffer_.size() - end_);
  if (count > 0) {
    std::memcpy(buffer_.data() + end_, bytes.data(), count);
  }
  end_ += count;
  stats_.bytes += count;
  return count;
}

core::Expected<FrameView> FrameParser::push(std::byte value) {
  if (push({&value, 1}) == 0) {
    return core::Status::kResourceExhausted;
  }
  return poll();
}

core::Expected<FrameView> FrameParser::poll() {
  if (end_ - begin_ < needed_ || !find_frame()) {
    return core::Status::kNotReady;
  }
  return deliver();
}

bool FrameParser::find_frame() {
  const std::byte* const last = buffer_.data() + end_;
  for (const std::byte* at = buffer_.data() + begin_;; ++at) {  // each turn ends the search or drops a byte
    at = std::find(at, last, kStartByte);
    const auto present = static_cast<std::size_t>(last - at);
    if (present < kHeaderBytes) {
      move_to(at, present == 0 ? 1 : kHeaderBytes);
      return false;
    }
    const std::size_t length = judge_header(at);
    if (length == 0) {
      continue;
    }
    if (present < length || length == kHeaderBytes || crc32({at, length}) == 0) {
      move_to(at, length);
      return present >= length;
    }
    count_error(&ParserStats::crc32_errors, at);
  }
}

inline std::size_t FrameParser::judge_header(const std::byte* at) {
  const bool due = in_step_ && at == buffer_.data() + delivered_;
  const bool readable = reserved_bits_are_zero(at);
  const std::size_t length = length_of(at);
  if ((!readable && !due) || crc16({at, kCrc16At}) != load<std::uint16_t>(at + kCrc16At)) {
    count_error(&ParserStats::crc16_errors, at);
  } else if (!readable) {
    count_error(&ParserStats::reserved_errors, at);
  } else if ((length < kFrameOverheadBytes && length != kHeaderBytes) || length > longest_frame_bytes_) {
    count_error(&ParserStats::length_errors, at);
  } else if (!padding_makes_sense(at, length)) {
    count_error(&ParserStats::padding_errors, at);
  } else {
    return length;
  }
  return 0;
}

inline void FrameParser::count_error(std::uint64_t ParserStats::*counter, const std::byte* at) {
  stats_.*counter += at >= buffer_.data() + delivered_ ? 1U : 0U;
}

void FrameParser::abandon_candidate() {
  if (needed_ > 1) {
    const std::byte* const at = buffer_.data() + begin_;
    count_error(needed_ > kHeaderBytes ? &ParserStats::crc32_errors : &ParserStats::crc16_errors, at);
    move_to(at + 1, 1);
  }
}

void FrameParser::move_to(const std::byte* at, std::size_t needed) {
  const auto position = static_cast<std::size_t>(at - buffer_.data());
  const std::size_t from = std::max(begin_, delivered_);
  begin_ = position;
  needed_ = needed;
  if (position > from) {
    stats_.bytes_dropped += position - from;
    stats_.resyncs += in_step_ ? 1U : 0U;
    in_step_ = false;
  }
}

FrameView FrameParser::deliver() {
  const std::size_t length = needed_;
  M100_ASSERT(length >= kHeaderBytes && begin_ + length <= end_);
  const std::span<const std::byte> bytes = std::span<const std::byte>(buffer_).subspan(begin_, length);
  const FrameView frame{.header = read_header(buffer_.data() + begin_),
                        .bytes = bytes,
                        .data = length == kHeaderBytes ? std::span<const std::byte>{}
                                                       : bytes.subspan(kHeaderBytes, length - kFrameOverheadBytes),
                        .offset = base_ + begin_};
  delivered_ = std::max(delivered_, begin_ + length);
  // A header may begin in the last bytes of a good frame; DJI's receiver looks there too.
  begin_ += length - kTailBytes;
  needed_ = 1;
  in_step_ = true;
  ++stats_.frames;
  return frame;
}

}  // namespace m100::protocol
