// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/link/command_channel.h"
#include "protocol/cipher.h"

namespace m100::link {

/// The last messages of a program that fails (assertion, hang, death): a neutral command, with Virtual RC its
/// switch-off, and two requests to release control. They are encoded at start-up, before anything can be broken;
/// sending them is one write of constant bytes, which a handler can do whatever the state of the program is.
///
/// The releases use the two highest sessions, which SerialLink does not reach: it opens the lowest free one.
class ReleaseSequence {
 public:
  static constexpr std::size_t kBytes = 256;

  /// Any number is valid for a single release sequence: the autopilot compares it with the last one of its session.
  static constexpr std::uint16_t kSequence = 0xFA2E;

  /// @param neutral command of the channel in use. @param cipher null: plain. @param sequence of all frames; to send a
  ///   release sequence again to an autopilot that was not restarted since, use another number.
  ReleaseSequence(const ChannelCommand& neutral, const protocol::Cipher* cipher, std::uint16_t sequence = kSequence);

  std::span<const std::byte> bytes() const { return std::span(bytes_).first(size_); }
  /// The sequence without the neutral command, for when the transmitter may have control already (R4).
  std::span<const std::byte> release_only() const { return bytes().subspan(neutral_size_); }

 private:
  template <typename Command>
  void append(const Command& command, std::uint8_t session, const protocol::Cipher* cipher, std::uint16_t sequence);

  std::array<std::byte, kBytes> bytes_{};
  std::size_t size_ = 0;
  std::size_t neutral_size_ = 0;
};

}  // namespace m100::link
