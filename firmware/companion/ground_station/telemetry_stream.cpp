// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/ground_station/telemetry_stream.h"

#include <malloc.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <variant>

namespace m100::companion {
namespace {

/// The aircraft's address; TIMESYNC comes from component 191 with its own sequence numbers.
constexpr mavlink::Address kAircraft{.system = 1, .component = 1};
constexpr std::uint8_t kLinkOfTheSpeaker = 2;  ///< the signatures of two threads are two streams
constexpr auto kLook = std::chrono::milliseconds(10);

}  // namespace

TelemetryStream::TelemetryStream(const LiveOptions& options, const hal::UdpPort* port,
                                 const std::optional<mavlink::Key>& key)
    : receiver_(receiver_of(options.to)), port_(port), key_(key) {
  if (receiver_) {
    descriptor_ = hal::Descriptor(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  } else if (port_ == nullptr) {
    return;
  }
  // Otherwise malloc would give this thread an arena of its own: 64 MB of addresses, all of which count as locked
  // memory. The thread that flies allocates nothing from the shared arena, so neither thread waits for the other.
  (void)mallopt(M_ARENA_MAX, 1);
  thread_ = std::jthread([this](const std::stop_token& ends) {
    while (!ends.stop_requested()) {
      send_all();
      std::this_thread::sleep_for(kLook);
    }
    send_all();
  });
}

void TelemetryStream::publish(const app::TickRecord<double>& record, mavlink::SignatureTime min_time) {
  if (thread_.joinable() && ticks_++ % kTicksPerState == 0) {
    min_time_ = min_time;
    (void)records_.push(record);
  }
}

void TelemetryStream::send_all() {
  app::TickRecord<double> record;
  while (records_.pop(record)) {
    send(record);
  }
  Reply reply;
  while (replies_.pop(reply)) {
    std::visit([this](const auto& message) { send(message); }, reply);
  }
  TextLine line;
  while (lines_.pop(line)) {
    send(line.text());
  }
}

template <typename Message>
void TelemetryStream::send(const Message& message) {
  if (port_ == nullptr) {
    return;
  }
  mavlink::Frame frame = mavlink::encode(message, kAircraft, frames_++);
  if (key_) {
    mavlink::sign(frame, *key_, kLinkOfTheSpeaker, ++time_);
  }
  (void)port_->send(frame.bytes());  // a message that cannot be sent is lost, as on the air
}

void TelemetryStream::send(const app::TickRecord<double>& record) {
  if (descriptor_.number >= 0) {
    const std::string text = json_of(record);
    (void)!::sendto(descriptor_.number, text.data(), text.size(), 0, reinterpret_cast<const sockaddr*>(&*receiver_),
                    sizeof(*receiver_));  // a packet that cannot be sent is lost, as on any network
  }
  const std::uint32_t state = states_++;
  if (state % kStatesPerMessage != 0) {
    return;
  }
  time_ = std::max<mavlink::SignatureTime>(time_, min_time_);
  send(attitude_of(record));
  send(position_of(record));
  if (state % kStatesPerHeartbeat == 0) {
    send(heartbeat_of(record));
    send(estimator_of(record));
    send(battery_of(record));
  }
}

void TelemetryStream::send(std::string_view line) {
  sentences_ = static_cast<std::uint16_t>(sentences_ == 0xFFFFU ? 1 : sentences_ + 1);
  mavlink::StatusText message;
  for (std::uint8_t piece = 0; status_text(line, severity_of(line), sentences_, piece, message); ++piece) {
    send(message);
  }
}

}  // namespace m100::companion
