// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hal/uart.h"

namespace m100::hal {

/// A line whose bytes come in packets of a network: each whole or not at all, from anybody, doubled or overtaken. What
/// is written in one call leaves in one packet.
class PacketUart : public Uart {
 public:
  /// Whether the bytes that read() gave last are the first of a packet.
  virtual bool begins_packet() const = 0;
  /// What is written from now on goes to whoever sent the packet that was read last. The caller knows whom to believe.
  virtual void answer_last() = 0;

 protected:
  PacketUart() = default;
  ~PacketUart() = default;
};

}  // namespace m100::hal
