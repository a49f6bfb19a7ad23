// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/release_sequence.h"

#include "firmware/core/assert.h"
#include "protocol/dji/frame_encoder.h"
#include "protocol/dji/session.h"

namespace m100::link {

ReleaseSequence::ReleaseSequence(const ChannelCommand& neutral, const protocol::Cipher* cipher,
                                 std::uint16_t sequence) {
  const auto* const sticks = std::get_if<vrc::Sticks>(&neutral);
  if (sticks != nullptr) {
    append(to_virtual_rc(*sticks), protocol::kUnansweredSession, cipher, sequence);
  } else {
    append(to_movement(std::get<ctl::Command<double>>(neutral)), protocol::kUnansweredSession, cipher, sequence);
  }
  neutral_size_ = size_;
  if (sticks != nullptr) {
    append(protocol::VirtualRcSwitch{.on = false, .fall_back_to_rc = true, .reserved = 0}, protocol::kUnansweredSession,
           cipher, sequence);
  }
  append(protocol::ControlRequest{.obtain = false}, protocol::kSessionCount - 2, cipher, sequence);
  append(protocol::ControlRequest{.obtain = false}, protocol::kSessionCount - 1, cipher, sequence);
}

template <typename Command>
void ReleaseSequence::append(const Command& command, std::uint8_t session, const protocol::Cipher* cipher,
                             std::uint16_t sequence) {
  const core::Expected<protocol::Value> value = encode(command);
  M100_ASSERT(value.has_value());  // fixed commands: the encoder is wrong
  const protocol::MessageId id = id_of(command);
  const core::Expected<std::span<const std::byte>> frame = protocol::encode_frame(
      {.session = session, .is_ack = false, .encrypted = cipher != nullptr, .sequence = sequence}, &id, *value,
      std::span(bytes_).subspan(size_), cipher);
  M100_ASSERT(frame.has_value());  // bytes_ is too small for the sequence
  size_ += frame->size();
}

}  // namespace m100::link
