// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/farewell.h"

#include "firmware/core/assert.h"
#include "protocol/frame_encoder.h"
#include "protocol/session.h"

namespace m100::app {
namespace {

/// Any numbers do: the autopilot compares with the last one of the same session, and these sessions are unused.
constexpr std::uint16_t kSequence = 0xFA2E;

}  // namespace

Farewell::Farewell(const ChannelCommand& neutral, const protocol::Cipher* cipher) {
  if (const auto* sticks = std::get_if<vrc::Sticks>(&neutral)) {
    append(to_virtual_rc(*sticks), protocol::kUnansweredSession, cipher);
    append(protocol::VirtualRcSwitch{.on = false, .fall_back_to_rc = true, .reserved = 0}, protocol::kUnansweredSession,
           cipher);
  } else {
    append(to_movement(std::get<ctl::Command<double>>(neutral)), protocol::kUnansweredSession, cipher);
  }
  append(protocol::ControlRequest{.obtain = false}, protocol::kSessionCount - 2, cipher);
  append(protocol::ControlRequest{.obtain = false}, protocol::kSessionCount - 1, cipher);
}

template <typename Command>
void Farewell::append(const Command& command, std::uint8_t session, const protocol::Cipher* cipher) {
  const core::Expected<protocol::Value> value = encode(command);
  M100_ASSERT(value.has_value());
  const protocol::MessageId id = id_of(command);
  const core::Expected<std::span<const std::byte>> frame = protocol::encode_frame(
      {.session = session, .is_ack = false, .encrypted = cipher != nullptr, .sequence = kSequence}, &id, *value,
      std::span(bytes_).subspan(size_), cipher);
  M100_ASSERT(frame.has_value());
  size_ += frame->size();
}

}  // namespace m100::app
