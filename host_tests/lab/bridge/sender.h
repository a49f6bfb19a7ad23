// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <string>

#include "hal/linux/descriptor.h"
#include "protocol/mavlink/frame.h"
#include "protocol/mavlink/signature.h"

namespace m100::lab::bridge {

/// Signs messages and sends them to one receiver; the receiver's messages arrive at the same socket.
class Sender {
 public:
  /// @param to an IPv4 address and a UDP port, as "127.0.0.1:14560". @throws InputError
  Sender(const std::string& to, const mavlink::Key& key);
  int descriptor() const { return socket_.number; }
  /// @returns false: the message was not sent.
  template <typename Message>
  bool send(const Message& message) {
    constexpr mavlink::Address kRoom{.system = 9, .component = 197};  // MAV_COMP_ID_VISUAL_INERTIAL_ODOMETRY
    return sign_and_send(mavlink::encode(message, kRoom, number_++));
  }

 private:
  bool sign_and_send(mavlink::Frame frame);

  mavlink::Key key_;
  sockaddr_in to_;
  hal::Descriptor socket_;
  mavlink::SignatureTime stamp_ = 0;  ///< of the last frame; always increases
  std::uint8_t number_ = 0;
};

}  // namespace m100::lab::bridge
