// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/frame_parser.h"

#include <algorithm>
#include <cstring>

#include "protocol/bytes.h"
#include "protocol/crc_kernels.h"

namespace m100::protocol {
namespace {

constexpr std::size_t kTailBytes = kHeaderBytes - 1;  // a header needs one byte more than is kept of a delivered frame

constexpr std::ptrdiff_t kHeader = kHeaderBytes;

const std::byte* find_start_byte(const std::byte* at, const std::byte* last) {
  const void* const start = std::memchr(at, std::to_integer<int>(kStartByte), static_cast<std::size_t>(last - at));
  return start != nullptr ? static_cast<const std::byte*>(start) : last;
}

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

/// Of the first eight bytes of a header: the start byte, and VER, RES0, RES1 all zero.
constexpr std::uint64_t kFixedBits = 0xFFFFFF00C0FC00FFU;

bool fixed_bits_hold(const std::byte* at) {
  return (load<std::uint64_t>(at) & kFixedBits) == std::to_integer<std::uint64_t>(kStartByte);
}

bool header_checksum_holds(const std::byte* at) {
  return crc_kernels::header_crc16(at) == load<std::uint16_t>(at + kHeaderBytes - 2);
}

/// A whole header whose checksum holds, but VER, RES0 or RES1 is not zero.
bool is_of_another_version(const std::byte* at, const std::byte* last) {
  return last - at >= kHeader && *at == kStartByte && !fixed_bits_hold(at) && header_checksum_holds(at);
}

/// Filler fits into DATA, and encrypted DATA is whole cipher blocks.
bool padding_makes_sense(const std::byte* at, std::size_t length) {
  const auto cipher = load<std::uint8_t>(at + 4);
  const std::size_t data_bytes = length > kHeaderBytes ? length - kFrameOverheadBytes : 0;
  const bool encrypted = cipher >= 0x20;
  return cipher == 0 || ((cipher & 0x1FU) <= data_bytes && (!encrypted || data_bytes % kCipherBlockBytes == 0));
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
  while (end_ - begin_ >= needed_) {  // each turn ends in a return, a longer need, or at least one byte less
    std::size_t from = begin_;
    if (needed_ > kHeaderBytes) {
      if (frame_checksum_holds()) {
        return deliver();
      }
      stats_.crc32_errors += begin_ >= delivered_ ? 1U : 0U;
      ++from;
    }
    if (seek(from) && length_ == kHeaderBytes) {
      return deliver();
    }
  }
  return core::Status::kNotReady;
}

bool FrameParser::seek(std::size_t from) {
  const std::byte* const edge = buffer_.data() + delivered_;
  const std::byte* const last = buffer_.data() + end_;
  const std::byte* at = buffer_.data() + from;
  if (in_step_ && at == edge && is_of_another_version(at, last)) {
    ++stats_.reserved_errors;
    ++at;
  }
  bool found = false;
  for (at = next_candidate(at, last); last - at >= kHeader; at = next_candidate(at + 1, last)) {
    std::uint64_t* const error = judge_header(at);
    found = error == nullptr;
    if (found) {
      break;
    }
    *error += at >= edge ? 1U : 0U;
  }
  drop_to(static_cast<std::size_t>(at - buffer_.data()));
  needed_ = found ? length_ : (at == last ? 1 : kHeaderBytes);
  return found;
}

const std::byte* FrameParser::next_candidate(const std::byte* at, const std::byte* last) {
  const std::byte* const edge = buffer_.data() + delivered_;
  std::uint64_t refused = 0;
  while (last - at >= kHeader && !fixed_bits_hold(at)) {
    if (*at == kStartByte) {
      refused += at >= edge ? 1U : 0U;
      ++at;
    } else {
      at = find_start_byte(at, last);
    }
  }
  stats_.crc16_errors += refused;
  return last - at >= kHeader ? at : find_start_byte(at, last);
}

std::uint64_t* FrameParser::judge_header(const std::byte* at) {
  if (!header_checksum_holds(at)) {
    return &stats_.crc16_errors;
  }
  length_ = length_of(at);
  if (length_ < kFrameOverheadBytes && length_ != kHeaderBytes) {
    return &stats_.length_errors;
  }
  return padding_makes_sense(at, length_) ? nullptr : &stats_.padding_errors;
}

void FrameParser::abandon_candidate() {
  if (needed_ > 1) {
    std::uint64_t& counter = needed_ > kHeaderBytes ? stats_.crc32_errors : stats_.crc16_errors;
    counter += begin_ >= delivered_ ? 1U : 0U;
    seek(begin_ + 1);
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
    running_first_ = running_first_ > blocks ? running_first_ - blocks : 0;
  } else {
    running_first_ = running_last_ = 0;
    running_[0] = 0;
  }
  if (known_position_ >= shift) {
    known_position_ -= shift;
  } else {
    known_position_ = running_first_ * kBlockBytes;
    known_crc_ = running_[running_first_];
  }
}

void FrameParser::drop_to(std::size_t position) {
  const std::size_t from = std::max(begin_, delivered_);
  begin_ = position;
  if (position > from) {
    stats_.bytes_dropped += position - from;
    stats_.resyncs += in_step_ ? 1U : 0U;
    in_step_ = false;
  }
}

bool FrameParser::frame_checksum_holds() {
  if (running_last_ < begin_ / kBlockBytes) {  // bytes in between belong to no candidate: start afresh behind them
    running_first_ = running_last_ = begin_ / kBlockBytes;
    running_[running_first_] = 0;
    known_position_ = running_first_ * kBlockBytes;
    known_crc_ = 0;
  }
  const std::uint32_t before = running_crc(begin_);
  return crc_kernels::advance(before ^ kCrc32Start, length_) == running_crc(begin_ + length_);
}

std::uint32_t FrameParser::running_crc(std::size_t position) {
  if (position == known_position_) {
    return known_crc_;
  }
  const std::size_t block = position / kBlockBytes;
  if (running_last_ < block) {
    crc_kernels::run_blocks(buffer_.data() + running_last_ * kBlockBytes, running_.data() + running_last_,
                            block - running_last_);
    running_last_ = block;
  }
  known_position_ = position;
  const std::size_t rest = position % kBlockBytes;
  known_crc_ = crc_kernels::step_rest(running_[block], buffer_.data() + block * kBlockBytes, rest);
  return known_crc_;
}

FrameView FrameParser::deliver() {
  const std::size_t length = length_;
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
