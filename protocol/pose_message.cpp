// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/pose_message.h"

#include <algorithm>
#include <cmath>

#include "firmware/core/assert.h"
#include "protocol/bytes.h"
#include "protocol/crc.h"

namespace m100::protocol {
namespace {

constexpr std::array<std::byte, 4> kBeginning{std::byte{'P'}, std::byte{'M'}, std::byte{1}, std::byte{0}};
constexpr std::size_t kSummedBytes = kPoseMessageBytes - sizeof(std::uint32_t);
constexpr float kFarthest_m = 1000.F;
constexpr float kLengthError = 0.02F;  // of the squared length: twice that of the length
constexpr std::uint32_t kOldest_us = 10000000;

PoseMessage decode(std::span<const std::byte> bytes) {
  PoseMessage message;
  ByteReader reader(bytes.subspan(kBeginning.size()));
  message.sequence = reader.take<std::uint32_t>();
  message.age_us = reader.take<std::uint32_t>();
  reader.take(message.position_w_m);
  reader.take(message.rotation_wb);
  return message;
}

}  // namespace

PoseBytes encode(const PoseMessage& message) {
  PoseBytes bytes{};
  ByteWriter writer(bytes);
  writer.put(std::span<const std::byte>(kBeginning));
  writer.put(message.sequence);
  writer.put(message.age_us);
  writer.put(message.position_w_m);
  writer.put(message.rotation_wb);
  writer.put(crc32(std::span(bytes).first(kSummedBytes)));
  M100_ASSERT(writer.ok() && writer.size() == kPoseMessageBytes);
  return bytes;
}

core::Status check(const PoseMessage& message) {
  float squared_length = 0.F;
  for (const float value : message.rotation_wb) {
    squared_length += value * value;
  }
  // A comparison with NaN is false, so each test states what is good.
  const bool near = std::all_of(message.position_w_m.begin(), message.position_w_m.end(),
                                [](float value) { return std::abs(value) <= kFarthest_m; });
  const bool unit = std::abs(squared_length - 1.F) <= kLengthError;
  return near && unit && message.age_us < kOldest_us ? core::Status::kOk : core::Status::kOutOfRange;
}

bool PoseParser::may_begin() const {
  return std::equal(window_.begin(), window_.begin() + static_cast<std::ptrdiff_t>(std::min(size_, kBeginning.size())),
                    kBeginning.begin());
}

void PoseParser::drop_first() {
  std::copy(window_.begin() + 1, window_.begin() + static_cast<std::ptrdiff_t>(size_), window_.begin());
  --size_;
  ++stats_.bytes_dropped;
}

void PoseParser::find_beginning() {
  while (size_ > 0 && !may_begin()) {
    drop_first();
  }
}

bool PoseParser::take(std::span<const std::byte>& bytes) {
  // Byte by byte while the beginning is being looked for, then all that the message lacks.
  const std::size_t wanted = size_ < kBeginning.size() ? 1 : kPoseMessageBytes - size_;
  const std::size_t count = std::min(wanted, bytes.size());
  std::copy_n(bytes.begin(), count, window_.begin() + static_cast<std::ptrdiff_t>(size_));
  bytes = bytes.subspan(count);
  stats_.bytes += count;
  size_ += count;
  if (size_ <= kBeginning.size()) {
    find_beginning();
  }
  return size_ == kPoseMessageBytes;
}

core::Expected<PoseMessage> PoseParser::judge() {
  if (crc32(std::span(window_).first(kSummedBytes)) != load<std::uint32_t>(window_.data() + kSummedBytes)) {
    ++stats_.crc_errors;
    drop_first();
    find_beginning();
    return core::Status::kNotReady;
  }
  size_ = 0;
  const PoseMessage message = decode(window_);
  if (check(message) != core::Status::kOk) {
    ++stats_.refused;
    return core::Status::kOutOfRange;
  }
  ++stats_.messages;
  return message;
}

}  // namespace m100::protocol
