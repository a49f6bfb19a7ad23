// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/dji/pushes.h"

#include <algorithm>

namespace m100::protocol {

core::Expected<Value> encode(const ControlLost& push) {
  return Value::of([&](ByteWriter& writer) { writer.put(push.value); });
}

core::Expected<Value> encode(const FromMobile& push) {
  if (push.data.size == 0 || push.data.size > MobileData::kMaxBytes) {
    return core::Status::kOutOfRange;
  }
  return Value::of([&](ByteWriter& writer) { writer.put(push.data.view()); });
}

core::Expected<Value> encode(const MissionStatus& push) {
  return Value::of([&](ByteWriter& writer) {
    writer.put(push.kind);
    writer.put(push.rest);
  });
}

core::Expected<Value> encode(const WaypointEvent& push) {
  return Value::of([&](ByteWriter& writer) {
    writer.put(push.event);
    writer.put(push.rest);
  });
}

core::Expected<Push> decode_push(MessageId id, std::span<const std::byte> value) {
  const MessageInfo* const info = find(id);
  if (info == nullptr || value.size() < info->min_value_bytes || value.size() > info->max_value_bytes) {
    return core::Status::kInvalidArgument;
  }
  ByteReader reader(value);
  if (id == ids::kControlLost) {
    return Push(ControlLost{reader.take<std::uint8_t>()});
  }
  if (id == ids::kFromMobile) {
    FromMobile push;
    std::copy(value.begin(), value.end(), push.data.bytes.begin());
    push.data.size = static_cast<std::uint8_t>(value.size());
    return Push(push);
  }
  if (id == ids::kMissionStatus) {
    MissionStatus push;
    push.kind = reader.take<std::uint8_t>();
    reader.take(push.rest);
    return Push(push);
  }
  if (id == ids::kWaypointEvent) {
    WaypointEvent push;
    push.event = reader.take<std::uint8_t>();
    reader.take(push.rest);
    return Push(push);
  }
  return core::Status::kInvalidArgument;
}

}  // namespace m100::protocol
