// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/frame_parser.h"

#include <algorithm>
#include <cstring>

#include "protocol/bytes.h"
#include "protocol/crc.h"

namespace m100::protocol {
namespace {

constexpr std::size_t kTailBytes = kHeaderBytes - 1;  // a header needs one byte more than is kept of a delivered frame

FrameHeader read_header(const std::byte* at) {
  const auto length = load<std::uint16_t>(at + 1);
  const auto flags = load<std::uint8_t>(at + 3);
  const auto cipher = load<std::uint8_t>(at + 4);
  return {.length_bytes = static_cast<std::uint16_t>(length & 0x3FFU),
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
  return crc16_of_header(at) == load<std::uint16_t>(at + kHeaderBytes - 2);
}

bool padding_makes_sense(const FrameHeader& header) {
  const std::size_t data_bytes =
      header.length_bytes > kHeaderBytes ? header.length_bytes - kFrameOverheadBytes : std::size_t{0};
  return header.padding_bytes <= data_bytes && (!header.encrypted() || data_bytes % kCipherBlockBytes == 0);
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
    if (needed_ > kHeaderBytes) {
      if (frame_checksum_holds()) {
        return deliver();
      }
      refuse(stats_.crc32_errors);
    }
    seek();
    needed_ = begin_ == end_ ? 1 : kHeaderBytes;
    if (end_ - begin_ >= kHeaderBytes && accept_header()) {
      if (header_.length_bytes == kHeaderBytes) {
        return deliver();
      }
      needed_ = header_.length_bytes;
    }
  }
  return core::Status::kNotReady;
}

void FrameParser::seek() {
  const std::byte* const edge = buffer_.data() + delivered_;
  const std::byte* const last = buffer_.data() + end_;
  const std::byte* at = buffer_.data() + begin_;
  std::uint64_t refused = 0;
  while (at < last) {
    if (*at != kStartByte) {
      const void* const found = std::memchr(at, std::to_integer<int>(kStartByte), static_cast<std::size_t>(last - at));
      at = found != nullptr ? static_cast<const std::byte*>(found) : last;
      continue;
    }
    if (last - at < static_cast<std::ptrdiff_t>(kHeaderBytes) || fixed_bits_hold(at)) {
      break;
    }
    if (in_step_ && at == edge && header_checksum_holds(at)) {
      ++stats_.reserved_errors;
    } else if (at >= edge) {
      ++refused;
    }
    ++at;
  }
  stats_.crc16_errors += refused;
  drop(static_cast<std::size_t>(at - buffer_.data()) - begin_);
}

void FrameParser::abandon_candidate() {
  if (needed_ > 1) {
    refuse(needed_ > kHeaderBytes ? stats_.crc32_errors : stats_.crc16_errors);
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

void FrameParser::drop(std::size_t count) {
  const std::size_t from = std::max(begin_, delivered_);
  begin_ += count;
  needed_ = 1;
  if (begin_ > from) {
    stats_.bytes_dropped += begin_ - from;
    stats_.resyncs += in_step_ ? 1U : 0U;
    in_step_ = false;
  }
}

void FrameParser::refuse(std::uint64_t& counter) {
  if (begin_ >= delivered_) {
    ++counter;
  }
  drop(1);
}

bool FrameParser::accept_header() {
  const std::byte* const at = buffer_.data() + begin_;
  if (!header_checksum_holds(at)) {
    refuse(stats_.crc16_errors);
    return false;
  }
  header_ = read_header(at);
  if (header_.length_bytes < kFrameOverheadBytes && header_.length_bytes != kHeaderBytes) {
    refuse(stats_.length_errors);
    return false;
  }
  if (!padding_makes_sense(header_)) {
    refuse(stats_.padding_errors);
    return false;
  }
  return true;
}

bool FrameParser::frame_checksum_holds() {
  const std::size_t last = begin_ + header_.length_bytes;
  if (running_last_ < begin_ / kBlockBytes) {  // bytes in between belong to no candidate: start afresh behind them
    running_first_ = running_last_ = begin_ / kBlockBytes;
    running_[running_first_] = 0;
    known_position_ = running_first_ * kBlockBytes;
    known_crc_ = 0;
  }
  const std::uint32_t before = running_crc(begin_);
  return crc32_advance(before ^ kCrc32Start, header_.length_bytes) == running_crc(last);
}

std::uint32_t FrameParser::running_crc(std::size_t position) {
  if (position == known_position_) {
    return known_crc_;
  }
  const std::size_t block = position / kBlockBytes;
  for (; running_last_ < block; ++running_last_) {
    running_[running_last_ + 1] =
        crc32({buffer_.data() + running_last_ * kBlockBytes, kBlockBytes}, running_[running_last_]);
  }
  known_position_ = position;
  known_crc_ = crc32({buffer_.data() + block * kBlockBytes, position % kBlockBytes}, running_[block]);
  return known_crc_;
}

FrameView FrameParser::deliver() {
  const std::size_t length = header_.length_bytes;
  const std::span<const std::byte> bytes = std::span<const std::byte>(buffer_).subspan(begin_, length);
  const FrameView frame{.header = header_,
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
