// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/mavlink/parser.h"

#include <algorithm>
#include <cstring>

#include "protocol/bytes.h"
#include "protocol/mavlink/known_messages.h"

namespace m100::mavlink {
namespace {

static_assert(kHeader2Bytes - 1 + kMaxPayloadBytes <= RunningChecksum::kMaxRangeBytes);

std::size_t number(const std::byte* bytes, std::size_t at) { return std::to_integer<std::size_t>(bytes[at]); }

bool is_start(std::byte value) { return value == kStart2 || value == kStart1; }

std::size_t header_bytes_of(const std::byte* at) { return *at == kStart2 ? kHeader2Bytes : kHeader1Bytes; }

bool has_signature(const std::byte* at) { return *at == kStart2 && (number(at, 2) & kSignedFlag) != 0; }

}  // namespace

std::size_t Parser::push(std::span<const std::byte> bytes) {
  if (begin_ > 0 && buffer_.size() - end_ < bytes.size()) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    sums_.shift(begin_);
    base_ += begin_;
    end_ -= begin_;
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

void Parser::begin_packet() {
  stats_.bytes_dropped += end_ - begin_;
  base_ += end_;
  begin_ = 0;
  end_ = 0;
  needed_ = 1;
  in_step_ = true;
  sums_.reset();
}

void Parser::move_to(const std::byte* at, std::size_t needed) {
  const auto begin = static_cast<std::size_t>(at - buffer_.data());
  stats_.bytes_dropped += begin - begin_;
  in_step_ = in_step_ && begin == begin_;
  begin_ = begin;
  needed_ = needed;
}

inline const MessageInfo* Parser::read_header(const std::byte* at, bool due) {
  const bool is_2 = *at == kStart2;
  if (is_2 && (number(at, 2) & ~std::size_t{kSignedFlag}) != 0) {
    stats_.incompatible += due ? 1U : 0U;
    return nullptr;
  }
  const std::uint32_t id = is_2 ? protocol::load<std::uint32_t>(at + kHeader2Bytes - 4) >> 8U
                                : protocol::load<std::uint8_t>(at + kHeader1Bytes - 1);
  const MessageInfo* const info = known_messages::find(id);
  if (info == nullptr) {
    stats_.unknown += due ? 1U : 0U;
    return nullptr;
  }
  // MAVLink 1 has no extensions and leaves no zeros out.
  return is_2 || number(at, 1) == info->min_bytes ? info : nullptr;
}

inline bool Parser::checksum_holds(const std::byte* at, std::size_t summed_bytes, const MessageInfo& info) {
  const auto begin = static_cast<std::size_t>(at - buffer_.data());
  const std::uint32_t sum = sums_.of_range(buffer_.data(), begin + 1, begin + summed_bytes);
  return protocol::step_crc(kChecksumTable, sum, info.crc_extra) == protocol::load<std::uint16_t>(at + summed_bytes);
}

const MessageInfo* Parser::find_frame() {
  const std::byte* const last = buffer_.data() + end_;
  const std::byte* const due = in_step_ ? buffer_.data() + begin_ : nullptr;
  for (const std::byte* at = buffer_.data() + begin_;; ++at) {  // each turn ends the search or drops a byte
    while (at != last && !is_start(*at)) {
      ++at;
    }
    const auto present = static_cast<std::size_t>(last - at);
    const std::size_t header_bytes = at != last ? header_bytes_of(at) : 1;
    if (present < header_bytes) {
      move_to(at, header_bytes);
      return nullptr;
    }
    const MessageInfo* const info = read_header(at, at == due);
    if (info == nullptr) {
      continue;
    }
    const std::size_t summed_bytes = header_bytes + number(at, 1);
    if (present < summed_bytes + kCrcBytes) {
      move_to(at, summed_bytes + kCrcBytes);
      return nullptr;
    }
    if (!checksum_holds(at, summed_bytes, *info)) {
      ++stats_.crc_errors;
      continue;
    }
    const std::size_t frame_bytes = summed_bytes + kCrcBytes + (has_signature(at) ? kSignatureBytes : 0);
    move_to(at, frame_bytes);
    return present < frame_bytes ? nullptr : info;  // null: the signature is still on its way
  }
}

core::Expected<FrameView> Parser::search() {
  const MessageInfo* const info = find_frame();
  if (info == nullptr) {
    return core::Status::kNotReady;
  }
  const std::byte* const at = buffer_.data() + begin_;
  const bool is_2 = *at == kStart2;
  const std::size_t sequence = is_2 ? 4 : 2;  // system and component follow
  const FrameView frame{
      .id = info->id,
      .from = {protocol::load<std::uint8_t>(at + sequence + 1), protocol::load<std::uint8_t>(at + sequence + 2)},
      .sequence = protocol::load<std::uint8_t>(at + sequence),
      .version = static_cast<std::uint8_t>(is_2 ? 2 : 1),
      .is_signed = has_signature(at),
      .bytes = {at, needed_},
      .payload = {at + header_bytes_of(at), number(at, 1)},
      .offset = base_ + begin_};
  begin_ += needed_;
  needed_ = 1;
  in_step_ = true;
  ++stats_.frames;
  return frame;
}

}  // namespace m100::mavlink
