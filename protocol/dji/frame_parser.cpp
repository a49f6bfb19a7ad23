// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/dji/frame_parser.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "firmware/core/assert.h"
#include "protocol/bytes.h"
#include "protocol/crc_kernels.h"
#include "protocol/header_search.h"

namespace m100::protocol {
namespace {

using namespace header_search;

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

/// Shows that two good headers cannot lie a byte apart. The second would have the bytes of the first without its start
/// byte, so its CRC16 would be the upper byte of the first one's plus this constant. The lower byte of the constant
/// would have to be zero, since the upper byte of the first one's CRC16 is the first byte of the second's.
constexpr std::uint16_t kCrc16OfNeighbour = [] {
  const auto step16 = [](std::uint32_t state, std::uint32_t byte) {
    state ^= byte;
    for (int bit = 0; bit < 8; ++bit) {
      state = (state & 1U) != 0 ? (state >> 1U) ^ 0xA001U : state >> 1U;
    }
    return state;
  };
  std::uint32_t apart = step16(kCrc16Start, kStartNumber) ^ kCrc16Start;
  for (std::size_t byte = 0; byte < kHeaderBytes - 2; ++byte) {
    apart = step16(apart, 0);
  }
  return static_cast<std::uint16_t>(apart);
}();
static_assert((kCrc16OfNeighbour & 0xFFU) != 0, "two good headers a byte apart would be possible");

/// Whether VER, RES0 or RES1 of a header is not zero, although its checksum holds.
bool is_of_another_version(const std::byte* at) {
  return crc_kernels::header_crc16(at) == load<std::uint16_t>(at + kHeaderBytes - 2);
}

/// Whether the filler fits into DATA, and encrypted DATA is whole cipher blocks.
bool padding_makes_sense(const std::byte* at, std::size_t length) {
  const auto cipher = load<std::uint8_t>(at + 4);
  const std::size_t data_bytes = length > kHeaderBytes ? length - kFrameOverheadBytes : 0;
  const bool encrypted = cipher >= 0x20;
  return cipher == 0 || ((cipher & 0x1FU) <= data_bytes && (!encrypted || data_bytes % kCipherBlockBytes == 0));
}

/// Judges 12 bytes whose fixed bits hold. @returns the length of the frame; 0 and a counted error: not a header.
std::size_t judge_header(const std::byte* at, ParserStats& stats, std::uint64_t weight) {
  if (crc_kernels::usual_header_crc16<kStartNumber>(at) != load<std::uint16_t>(at + kHeaderBytes - 2)) {
    stats.crc16_errors += weight;
    return 0;
  }
  const std::size_t length = length_of(at);
  if (length < kFrameOverheadBytes && length != kHeaderBytes) {
    stats.length_errors += weight;
    return 0;
  }
  if (!padding_makes_sense(at, length)) {
    stats.padding_errors += weight;
    return 0;
  }
  return length;
}

/// Whether the CRC32 of the frame at buffer[begin] is right.
/// @param running as FrameParser::running_; @param known its last computed entry.
///
/// The register of a frame that begins here differs from the running one by a value whose change does not depend on the
/// bytes. This difference is computed at the first block border inside the frame and carried to the last one. If the
/// running register starts inside this frame, as it does while every frame is whole, it starts as the frame's own
/// register, and the difference is zero.
bool frame_checksum_holds(const std::byte* buffer, std::uint32_t* running, std::size_t& known, std::size_t begin,
                          std::size_t length) {
  const std::size_t first = begin / kCrc32BlockBytes + 1;
  const std::size_t last = (begin + length - 1) / kCrc32BlockBytes;
  if (kCrc32BlockBytes >= kFrameOverheadBytes && last < first) {  // the shortest frame, all in one block
    return crc_kernels::step_rest(kCrc32Start, buffer + begin, length) == 0;
  }
  const std::uint32_t own =
      crc_kernels::after_header_start<kStartNumber>(buffer + begin, first * kCrc32BlockBytes - begin);
  if (known < first) {  // the bytes in between belong to no candidate: restart after them
    known = first;
    running[first] = own;
  }
  if (known < last) {
    crc_kernels::run_blocks(buffer + known * kCrc32BlockBytes, running + known, last - known);
    known = last;
  }
  const std::size_t edge = last * kCrc32BlockBytes;
  const std::uint32_t apart_first = running[first] ^ own;
  // With the large tables, advancing a zero register is cheaper than testing for zero.
  const bool advances = crc_kernels::kLarge || apart_first != 0;
  const std::uint32_t apart = advances ? crc_kernels::advance_blocks(apart_first, last - first) : 0;
  return crc_kernels::ends_well(running[last] ^ apart, buffer + edge, begin + length - edge);
}

}  // namespace

std::size_t FrameParser::push(std::span<const std::byte> bytes) {
  if (buffer_.size() - end_ < bytes.size()) {
    make_room();
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
  if (end_ - begin_ < needed_ || !search(buffer_.data() + begin_)) {
    return core::Status::kNotReady;
  }
  return deliver();
}

bool FrameParser::search(const std::byte* at) {
  const std::byte* const last = buffer_.data() + end_;
  std::size_t length = needed_ > kHeaderBytes ? needed_ : 0;  // of the header at `at`, if there is one
  for (;;) {                                                  // each turn ends the search or advances at least one byte
    if (length == 0) {
      length = find_header(at, last);
    }
    if (length == 0) {
      return false;
    }
    const auto begin = static_cast<std::size_t>(at - buffer_.data());
    if (length == kHeaderBytes || frame_checksum_holds(buffer_.data(), running_.data(), running_last_, begin, length)) {
      move_to(at, length);
      return true;
    }
    at = refuse_frame(at);
    length = 0;
  }
}

inline std::size_t FrameParser::find_header(const std::byte*& at, const std::byte* last) {
  for (;;) {  // each turn ends the search or advances at least one byte
    if (last - at < kHeader || !fixed_bits_hold(at)) {
      at = next_candidate(at, last);
    }
    if (last - at < kHeader) {
      move_to(at, at == last ? 1 : kHeaderBytes);
      return 0;
    }
    const std::size_t length = judge_header(at, stats_, outside_delivered(at));
    if (static_cast<std::size_t>(last - at) < length) {
      move_to(at, length);
      return 0;
    }
    if (length != 0) {
      return length;
    }
    ++at;
  }
}

const std::byte* FrameParser::next_candidate(const std::byte* at, const std::byte* last) {
  const std::byte* const edge = buffer_.data() + delivered_;
  while (last - at >= kHeader && !fixed_bits_hold(at)) {
    if (last - at >= kRoomForWord && at > edge) {
      at = after_word(at, last);
      continue;
    }
    if (*at == kStartByte) {
      refuse_start(at);
    }
    at = find_start_byte(at + 1, last);
  }
  return last - at >= kHeader ? at : find_start_byte(at, last);
}

inline const std::byte* FrameParser::after_word(const std::byte* at, const std::byte* last) {
  const std::uint64_t starts = zero_bytes(load<std::uint64_t>(at) ^ kStartBytes);
  if (starts == 0) {
    at += kWord;
    const bool next_too = last - at >= kRoomForWord && zero_bytes(load<std::uint64_t>(at) ^ kStartBytes) == 0;
    return next_too ? find_start_byte(at + kWord, last) : at;
  }
  // The first place has been judged. Of the other start bytes, those with a zero at kLastZero may begin a header.
  const std::uint64_t possible = starts & zero_bytes(load<std::uint64_t>(at + kLastZero)) & kNotFirst;
  const std::uint64_t refused = possible != 0 ? starts & (possible - 1) & ~possible : starts;
  if (refused != 0) {
    stats_.crc16_errors += (refused >> 7U) * kOnes >> 56U;
  }
  return at + (possible != 0 ? std::countr_zero(possible) / 8 : kWord);
}

void FrameParser::refuse_start(const std::byte* at) {
  const bool due = in_step_ && at == buffer_.data() + delivered_;
  std::uint64_t& counter = due && is_of_another_version(at) ? stats_.reserved_errors : stats_.crc16_errors;
  counter += outside_delivered(at);
}

const std::byte* FrameParser::refuse_frame(const std::byte* at) {
  // No good header begins in the first eight bytes of another. Bytes 2 and 3 (VER, RES0) and 5 to 7 (zero) are not
  // start bytes. One at byte 1 fails its CRC16 (see kCrc16OfNeighbour), one at byte 4 has LEN 0. Both are only counted.
  constexpr std::ptrdiff_t kSkipped = 8;
  const bool may_have_length_zero = at[4] == kStartByte && (load<std::uint32_t>(at + 8) & 0xFFFFFF00U) == 0;
  if (at < buffer_.data() + delivered_ || may_have_length_zero) {
    stats_.crc32_errors += outside_delivered(at);
    return at + 1;
  }
  ++stats_.crc32_errors;
  stats_.crc16_errors += (at[1] == kStartByte ? 1U : 0U) + (at[4] == kStartByte ? 1U : 0U);
  return at + kSkipped;
}

void FrameParser::abandon_candidate() {
  if (needed_ > 1) {
    const std::byte* const at = buffer_.data() + begin_;
    std::uint64_t& counter = needed_ > kHeaderBytes ? stats_.crc32_errors : stats_.crc16_errors;
    counter += outside_delivered(at);
    move_to(at + 1, 1);
  }
}

void FrameParser::make_room() {
  const std::size_t shift = begin_ - begin_ % kBlockBytes;  // whole blocks, so that running_ stays aligned
  if (shift == 0) {
    return;
  }
  std::memmove(buffer_.data(), buffer_.data() + shift, end_ - shift);
  begin_ -= shift;
  end_ -= shift;
  delivered_ = delivered_ > shift ? delivered_ - shift : 0;
  base_ += shift;
  const std::size_t blocks = shift / kBlockBytes;
  if (running_last_ >= blocks) {
    std::copy(running_.begin() + static_cast<std::ptrdiff_t>(blocks),
              running_.begin() + static_cast<std::ptrdiff_t>(running_last_ + 1), running_.begin());
    running_last_ -= blocks;
  } else {
    running_last_ = 0;
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
