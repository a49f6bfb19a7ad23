// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>

#include "firmware/companion/preflight/check_result.h"
#include "firmware/link/telemetry/telemetry_check.h"
#include "hal/uart.h"
#include "protocol/dji/frame_parser.h"
#include "protocol/dji/session.h"
#include "protocol/dji/telemetry.h"

namespace m100::companion::preflight {

/// Decodes the autopilot's telemetry; sends nothing.
class TelemetryReceiver {
 public:
  explicit TelemetryReceiver(hal::Uart& uart) : uart_(uart) {}
  /// Reads what has arrived. @returns whether a message with attitude and specific force is known and one has come
  bool listen() {
    is_new_ = false;
    for (auto count = uart_.read(buffer_); count && *count > 0; count = uart_.read(buffer_)) {
      parser_.consume(std::span<const std::byte>(buffer_).first(*count),
                      [this](const protocol::FrameView& frame) { receive(frame); });
    }
    return is_new_ && has_all();
  }
  const protocol::Telemetry& telemetry() const { return telemetry_; }
  bool has_all() const {
    return telemetry_.has(protocol::TelemetryItem::kAttitude) && telemetry_.has(protocol::TelemetryItem::kAcceleration);
  }
  /// What is missing, while has_all() is false. @param name of the check
  CheckResult missing(const char* name, Health health) const {
    return received_ ? CheckResult{name, health, "telemetry without attitude or acceleration",
                                   "set both items to 100 Hz in DJI's assistant"}
                     : CheckResult{name, health, "no telemetry came", "m100 probe tells why"};
  }

 private:
  void receive(const protocol::FrameView& frame) {
    const core::Expected<protocol::Message> message = protocol::open(frame, nullptr, scratch_);
    if (!message || message->header.is_ack || !message->has_id || message->id != protocol::ids::kTelemetry) {
      return;
    }
    const protocol::Telemetry former = telemetry_;
    if (protocol::decode_telemetry(message->value, telemetry_) == core::Status::kOk) {
      (void)link::reject_non_finite(telemetry_, former);
      received_ = is_new_ = true;
    }
  }

  hal::Uart& uart_;
  std::array<std::byte, 4096> buffer_{};
  protocol::FrameParser parser_;
  protocol::CipherScratch scratch_{};
  protocol::Telemetry telemetry_;
  bool received_ = false;
  bool is_new_ = false;
};

}  // namespace m100::companion::preflight
