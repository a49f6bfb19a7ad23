// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string_view>
#include <thread>

#include "firmware/companion/ground_station/requests.h"
#include "firmware/companion/ground_station/state_messages.h"
#include "firmware/companion/operator/live_display.h"
#include "firmware/companion/operator/text_line.h"
#include "firmware/core/spsc_ring.h"
#include "hal/linux/descriptor.h"
#include "hal/linux/udp_port.h"
#include "protocol/mavlink/frame.h"
#include "protocol/mavlink/signature.h"

namespace m100::companion {

/// Sends the flight over UDP from a thread of its own: as JSON to the receiver of --live, fifty times a second,
/// unsigned and one-way, and as MAVLink to the ground station, signed if there is a key. The thread that flies hands
/// over copies and neither waits nor allocates. ATTITUDE_QUATERNION and LOCAL_POSITION_NED are sent ten times a second;
/// HEARTBEAT, ESTIMATOR_STATUS and BATTERY_STATUS once a second; lines for the operator (STATUSTEXT) and answers as
/// they come. The ground station is the sender of the last accepted packet.
class TelemetryStream {
 public:
  static constexpr std::uint32_t kTicksPerState = 2;
  static constexpr std::uint32_t kStatesPerMessage = 5;
  static constexpr std::uint32_t kStatesPerHeartbeat = 50;
  static constexpr std::size_t kMaxLineChars = 250;  ///< characters; the rest of a line is cut off

  /// @param port of the ground station, must outlive it; null: there is none. @param key nullopt: the messages are not
  /// signed. Errors: UsageError.
  TelemetryStream(const LiveOptions& options, const hal::UdpPort* port, const std::optional<mavlink::Key>& key);

  // Called by the thread that flies. A message that finds no room is not sent.
  /// Call it every tick. @param min_time least time stamp of the signatures
  void publish(const app::TickRecord<double>& record, mavlink::SignatureTime min_time);
  void publish(std::string_view line) { (void)lines_.push(TextLine{}.add(line.substr(0, kMaxLineChars))); }
  void publish(const Reply& reply) { (void)replies_.push(reply); }

 private:
  void send_all();
  void send(const app::TickRecord<double>& record);
  void send(std::string_view line);
  template <typename Message>
  void send(const Message& message);

  std::optional<sockaddr_in> receiver_;
  hal::Descriptor descriptor_;  ///< to the receiver
  const hal::UdpPort* port_;
  std::optional<mavlink::Key> key_;
  std::atomic<mavlink::SignatureTime> min_time_{0};  ///< of the signatures of the next messages
  core::SpscRing<app::TickRecord<double>, 64> records_;
  core::SpscRing<TextLine, 16> lines_;
  core::SpscRing<Reply, 64> replies_;
  std::uint32_t ticks_ = 0;
  // Used by the sending thread.
  std::uint32_t states_ = 0;
  std::uint16_t sentences_ = 0;
  std::uint8_t frames_ = 0;
  mavlink::SignatureTime time_ = 0;
  std::jthread thread_;  ///< last, because its end sends the rest of the queues
};

}  // namespace m100::companion
