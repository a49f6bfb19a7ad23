// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "firmware/app/command_channel.h"
#include "protocol/cipher.h"

namespace m100::app {

/// The last words of a program whose own invariants are broken (M100_ASSERT): neutral commands, Virtual RC off, control
/// released, and asked for twice as the protocol wants it. Made at start-up, when everything still holds; saying them
/// is one write of constant bytes, which a handler may do whatever the state of the rest is.
///
/// The releases travel in the two highest sessions, which SerialLink never opens: it takes the lowest free one.
class Farewell {
 public:
  static constexpr std::size_t kBytes = 256;

  /// @param neutral command of the channel in use. @param cipher null: plain.
  Farewell(const ChannelCommand& neutral, const protocol::Cipher* cipher);

  std::span<const std::byte> bytes() const { return std::span(bytes_).first(size_); }

 private:
  template <typename Command>
  void append(const Command& command, std::uint8_t session, const protocol::Cipher* cipher);

  std::array<std::byte, kBytes> bytes_{};
  std::size_t size_ = 0;
};

}  // namespace m100::app
