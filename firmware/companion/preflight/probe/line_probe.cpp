// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/preflight/probe/line_probe.h"

#include <array>

#include "protocol/bytes.h"
#include "protocol/dji/catalogue.h"

namespace m100::companion {
namespace {

/// Firmware 2.3: time is a bare u32, the gimbal has no limit byte, control no mode byte (protocol, section 8).
constexpr std::array<std::uint8_t, protocol::kTelemetryItemCount> kOldItemBytes{4, 16, 12, 13, 12, 25,
                                                                                6, 12, 12, 1,  1,  1};
constexpr double kNoisyShare = 0.05;  ///< largest share of the bytes outside of frames on a good line
/// Share of bytes without a stop bit. At a wrong rate any bit may be at the place of the stop bit: about half of the
/// bytes lack it. Noise that hit the stop bits of a tenth of all bytes would destroy every frame; no line is that bad.
constexpr double kFramingShareOfWrongBaud = 0.1;
constexpr double kBreakShare = 0.5;  ///< breaks per byte

std::size_t old_value_bytes(std::uint16_t items) {
  std::size_t size = 2;
  for (std::size_t item = 0; item < kOldItemBytes.size(); ++item) {
    size += ((std::uint32_t{items} >> item) & 1U) != 0 ? kOldItemBytes[item] : 0U;
  }
  return size;
}

}  // namespace

void LineProbe::receive(std::span<const std::byte> bytes) {
  mavlink_.consume(bytes, [](const mavlink::FrameView& /*frame*/) {});
  parser_.consume(bytes, [&](const protocol::FrameView& frame) {
    const core::Expected<protocol::Message> message = protocol::open(frame, nullptr, scratch_);
    if (message && message->has_id && message->id == protocol::ids::kTelemetry) {
      receive_telemetry(message->value);
    } else if (!message && frame.header.session == 0 && !frame.header.is_ack) {
      ++packages_;  // encrypted telemetry: only telemetry sends such messages in session 0
    }
  });
}

void LineProbe::receive_telemetry(std::span<const std::byte> value) {
  ++packages_;
  fit_m100_ += protocol::decode_telemetry(value, telemetry_) == core::Status::kOk ? 1U : 0U;
  if (value.size() >= sizeof(std::uint16_t)) {
    const auto items = protocol::load<std::uint16_t>(value.data());
    fit_old_ += value.size() == old_value_bytes(items) ? 1U : 0U;
  }
}

Verdict LineProbe::without_frames(const core::Expected<hal::LineErrors>& errors) const {
  if (!errors) {
    return Verdict::kWrongBaud;  // by far the most frequent cause
  }
  const auto bytes = static_cast<double>(parser_.stats().bytes);
  if (errors->breaks > 0 && errors->breaks >= kBreakShare * bytes) {
    return Verdict::kLineHeldLow;
  }
  const double share = static_cast<double>(errors->framing) / bytes;
  return share > kFramingShareOfWrongBaud ? Verdict::kWrongBaud
                                          : (errors->framing > 0 ? Verdict::kNoisy : Verdict::kNoAutopilot);
}

Verdict LineProbe::verdict(const core::Expected<hal::LineErrors>& errors) const {
  const protocol::ParserStats& stats = parser_.stats();
  if (stats.bytes == 0) {
    return errors && errors->breaks > 0 ? Verdict::kLineHeldLow : Verdict::kNothingReceived;
  }
  if (stats.frames == 0 && mavlink_.stats().frames > 0) {
    return Verdict::kPosePort;
  }
  if (stats.frames == 0) {
    return without_frames(errors);
  }
  if (packages_ == 0) {
    return Verdict::kApiNotEnabled;
  }
  const double lost = static_cast<double>(stats.bytes_dropped) / static_cast<double>(stats.bytes);
  if (lost <= kNoisyShare) {
    return Verdict::kAutopilot;
  }
  return errors && errors->overrun > errors->framing ? Verdict::kOverrun : Verdict::kNoisy;
}

Firmware LineProbe::firmware() const {
  if (packages_ == 0) {
    return Firmware::kUnknown;
  }
  if (fit_m100_ == packages_) {
    return Firmware::kM100;
  }
  return fit_old_ == packages_ ? Firmware::kM100Old : Firmware::kOther;
}

std::string_view name(Verdict verdict) {
  switch (verdict) {
    case Verdict::kAutopilot:
      return "autopilot";
    case Verdict::kApiNotEnabled:
      return "api_not_enabled";
    case Verdict::kWrongBaud:
      return "wrong_baud";
    case Verdict::kNoAutopilot:
      return "no_autopilot";
    case Verdict::kNoisy:
      return "noisy";
    case Verdict::kOverrun:
      return "overrun";
    case Verdict::kLineHeldLow:
      return "line_held_low";
    case Verdict::kPosePort:
      return "pose_port";
    case Verdict::kNothingReceived:
      return "nothing_received";
    case Verdict::kCannotOpen:
      return "cannot_open";
  }
  return "unknown";
}

std::string_view remedy(Verdict verdict) {
  switch (verdict) {
    case Verdict::kAutopilot:
      return "";
    case Verdict::kApiNotEnabled:
      return "the autopilot speaks but sends no telemetry: tick \"enable API control\" in DJI's assistant and set the "
             "telemetry rates there";
    case Verdict::kWrongBaud:
      return "bytes arrive, but no frame: set the baud rate that DJI's assistant shows, and check that this is the "
             "autopilot's port";
    case Verdict::kNoisy:
      return "frames arrive, but many are damaged: shorten or shield the cable, check the common ground, close other "
             "programs on this port";
    case Verdict::kNoAutopilot:
      return "bytes arrive undamaged, but no frame: another device speaks at this rate; check that this is the "
             "autopilot's "
             "port";
    case Verdict::kOverrun:
      return "frames arrive, but this machine takes its bytes too late: lower the telemetry rates in DJI's assistant, "
             "and "
             "close other programs";
    case Verdict::kLineHeldLow:
      return "the line is held low: switch the autopilot on, and check that RX, TX and ground are not exchanged or "
             "shorted";
    case Verdict::kPosePort:
      return "MAVLink poses come at this port: --port and --pose-port are exchanged, or the adapters changed their "
             "names";
    case Verdict::kNothingReceived:
      return "not one byte: switch the aircraft on, cross RX and TX at UART_CAN2, and tick \"enable API control\" in "
             "DJI's assistant";
    case Verdict::kCannotOpen:
      return "the port cannot be opened: m100 doctor tells why";
  }
  return "";
}

std::string_view name(Firmware firmware) {
  switch (firmware) {
    case Firmware::kUnknown:
      return "unknown";
    case Firmware::kM100:
      return "M100, firmware 3.1";
    case Firmware::kM100Old:
      return "M100, firmware 2.3";
    case Firmware::kOther:
      return "not an M100, or another firmware";
  }
  return "unknown";
}

}  // namespace m100::companion
