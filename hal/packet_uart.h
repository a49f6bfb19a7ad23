// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hal/uart.h"

namespace m100::hal {

/// A line whose bytes arrive in network packets. A packet arrives whole or not at all; it may come from any sender, and
/// may be duplicated or overtaken. Each call of write() sends one packet.
class PacketUart : public Uart {
 public:
  /// Whether the bytes that read() returned last are the first of a packet.
  virtual bool begins_packet() const = 0;
  /// Sends all further writes to the sender of the packet that was read last. The caller has accepted that sender.
  virtual void answer_last() = 0;

 protected:
  PacketUart() = default;
  ~PacketUart() = default;
};

}  // namespace m100::hal
