// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/mavlink/parser.h"

#include <algorithm>

#include "protocol/bytes.h"

namespace m100::mavlink {
namespace {

std::uint8_t number(std::span<const std::byte> bytes, std::size_t at) {
  return std::to_integer<std::uint8_t>(bytes[at]);
}

bool checksum_holds(std::span<const std::byte> frame, std::size_t summed, const MessageInfo& info) {
  const std::byte extra{info.crc_extra};
  return checksum(std::span(&extra, 1), checksum(frame.subspan(1, summed - 1))) ==
         protocol::load<std::uint16_t>(frame.data() + summed);
}

}  // namespace

std::size_t Parser::push(std::span<const std::byte> bytes) {
  if (begin_ > 0 && buffer_.size() - end_ < bytes.size()) {
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_),
              buffer_.begin() + static_cast<std::ptrdiff_t>(end_), buffer_.begin());
    base_ += begin_;
    end_ -= begin_;
    begin_ = 0;
  }
  const std::size_t count = std::min(bytes.size(), buffer_.size() - end_);
  std::copy_n(bytes.begin(), count, buffer_.begin() + static_cast<std::ptrdiff_t>(end_));
  end_ += count;
  stats_.bytes += count;
  return count;
}

void Parser::begin_packet() {
  stats_.bytes_dropped += end_ - begin_;
  base_ += end_;
  begin_ = 0;
  end_ = 0;
  in_step_ = true;
}

void Parser::drop_first() {
  ++begin_;
  ++stats_.bytes_dropped;
  in_step_ = false;
}

core::Expected<FrameView> Parser::poll() {
  while (begin_ < end_) {  // each turn ends the loop or drops a byte
    Judgement judgement = judge(std::span<const std::byte>(buffer_).subspan(begin_, end_ - begin_));
    if (judgement.verdict == Verdict::kTooShort) {
      return core::Status::kNotReady;
    }
    if (judgement.verdict == Verdict::kFrame) {
      judgement.frame.offset = base_ + begin_;
      begin_ += judgement.frame.bytes.size();
      in_step_ = true;
      ++stats_.frames;
      return judgement.frame;
    }
    drop_first();
  }
  return core::Status::kNotReady;
}

Parser::Judgement Parser::judge(std::span<const std::byte> bytes) {
  if (bytes[0] == kStart2) {
    return judge_2(bytes);
  }
  return bytes[0] == kStart1 ? judge_1(bytes) : Judgement{};
}

Parser::Judgement Parser::judge_2(std::span<const std::byte> bytes) {
  if (bytes.size() > 2 && (number(bytes, 2) & ~unsigned{kSignedFlag}) != 0) {
    stats_.incompatible += in_step_ ? 1U : 0U;
    return {};
  }
  if (bytes.size() < kHeader2Bytes) {
    return {.verdict = Verdict::kTooShort, .frame = {}};
  }
  const std::uint32_t id =
      number(bytes, 7) | (std::uint32_t{number(bytes, 8)} << 8U) | (std::uint32_t{number(bytes, 9)} << 16U);
  const MessageInfo* const info = find_message(id);
  if (info == nullptr) {
    stats_.unknown += in_step_ ? 1U : 0U;
    return {};
  }
  const std::size_t payload = number(bytes, 1);
  const bool is_signed = (number(bytes, 2) & kSignedFlag) != 0;
  const std::size_t summed = kHeader2Bytes + payload;
  const std::size_t whole = summed + kCrcBytes + (is_signed ? kSignatureBytes : 0);
  if (bytes.size() >= summed + kCrcBytes && !checksum_holds(bytes, summed, *info)) {
    ++stats_.crc_errors;
    return {};
  }
  if (bytes.size() < whole) {
    return {.verdict = Verdict::kTooShort, .frame = {}};
  }
  return {.verdict = Verdict::kFrame,
          .frame = {.id = id,
                    .from = {number(bytes, 5), number(bytes, 6)},
                    .sequence = number(bytes, 4),
                    .version = 2,
                    .is_signed = is_signed,
                    .bytes = bytes.first(whole),
                    .payload = bytes.subspan(kHeader2Bytes, payload)}};
}

Parser::Judgement Parser::judge_1(std::span<const std::byte> bytes) {
  if (bytes.size() < kHeader1Bytes) {
    return {.verdict = Verdict::kTooShort, .frame = {}};
  }
  const MessageInfo* const info = find_message(number(bytes, 5));
  const std::size_t payload = number(bytes, 1);
  if (info == nullptr || payload != info->min_bytes) {  // MAVLink 1 has no extensions and leaves no zeros out
    stats_.unknown += in_step_ && info == nullptr ? 1U : 0U;
    return {};
  }
  const std::size_t summed = kHeader1Bytes + payload;
  if (bytes.size() < summed + kCrcBytes) {
    return {.verdict = Verdict::kTooShort, .frame = {}};
  }
  if (!checksum_holds(bytes, summed, *info)) {
    ++stats_.crc_errors;
    return {};
  }
  return {.verdict = Verdict::kFrame,
          .frame = {.id = info->id,
                    .from = {number(bytes, 3), number(bytes, 4)},
                    .sequence = number(bytes, 2),
                    .version = 1,
                    .is_signed = false,
                    .bytes = bytes.first(summed + kCrcBytes),
                    .payload = bytes.subspan(kHeader1Bytes, payload)}};
}

}  // namespace m100::mavlink
