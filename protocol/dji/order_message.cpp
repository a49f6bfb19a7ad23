// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/dji/order_message.h"

#include <algorithm>
#include <cstdint>
#include <span>

#include "firmware/core/assert.h"
#include "protocol/bytes.h"
#include "protocol/crc.h"

namespace m100::protocol {
namespace {

constexpr std::array<std::byte, 3> kBeginning{std::byte{'P'}, std::byte{'O'}, std::byte{1}};
constexpr std::size_t kSummedBytes = kOrderMessageBytes - sizeof(std::uint32_t);

}  // namespace

OrderBytes encode_order(bool program_flies) {
  OrderBytes bytes{};
  ByteWriter writer(bytes);
  writer.put(std::span<const std::byte>(kBeginning));
  writer.put(static_cast<std::uint8_t>(program_flies ? 1 : 0));
  writer.put(crc32(std::span<const std::byte>(bytes).first(kSummedBytes)));
  M100_ASSERT(writer.ok() && writer.size() == kOrderMessageBytes);
  return bytes;
}

core::Expected<bool> OrderParser::push(std::byte value) {
  std::rotate(last_.begin(), last_.begin() + 1, last_.end());
  last_.back() = value;
  const auto position = std::to_integer<unsigned>(last_[kBeginning.size()]);
  if (!std::equal(kBeginning.begin(), kBeginning.end(), last_.begin()) || position > 1) {
    return core::Status::kNotReady;
  }
  const std::span<const std::byte> bytes(last_);
  if (load<std::uint32_t>(bytes.subspan(kSummedBytes).data()) != crc32(bytes.first(kSummedBytes))) {
    return core::Status::kDataLoss;
  }
  return position == 1;
}

}  // namespace m100::protocol
