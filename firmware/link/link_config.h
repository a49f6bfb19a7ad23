// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "firmware/link/command_channel.h"
#include "protocol/cipher.h"
#include "protocol/dji/commands.h"

namespace m100::link {

struct LinkConfig {
  ChannelConfig channel;
  std::uint32_t app_id = 0;                  ///< from DJI's developer site
  const protocol::Cipher* cipher = nullptr;  ///< the key of that app; null: nothing is encrypted or decrypted
  bool encrypt_commands = false;             ///< all but command set 0x00; answers may be plain or encrypted
  std::uint32_t baud = 230400;               ///< for line times (arrival of frames) and the shares in LinkHealth
  /// Rate of each telemetry item, by its bit number. RC and control at 100 Hz: they show a loss of control.
  std::array<protocol::Rate, 12> rates{protocol::Rate::k100Hz, protocol::Rate::k100Hz, protocol::Rate::k100Hz,
                                       protocol::Rate::k100Hz, protocol::Rate::k100Hz, protocol::Rate::k10Hz,
                                       protocol::Rate::kOff,   protocol::Rate::k100Hz, protocol::Rate::kOff,
                                       protocol::Rate::k10Hz,  protocol::Rate::k1Hz,   protocol::Rate::k100Hz};

  bool uses_virtual_rc() const { return channel.channel == Channel::kVirtualRc; }
};

}  // namespace m100::link
