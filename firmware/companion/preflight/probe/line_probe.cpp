// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/preflight/probe/line_probe.h"

#include <array>

#include "firmware/core/assert.h"
#include "firmware/link/telemetry/telemetry_check.h"
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

/// What is said of each verdict.
struct VerdictRow {
  Verdict verdict;
  std::string_view name;
  int rank;
  std::string_view remedy;
};
constexpr std::array kVerdicts{
    VerdictRow{Verdict::kAutopilot, "autopilot", 0, ""},
    VerdictRow{
        Verdict::kApiNotEnabled, "api_not_enabled", 2,
        "the autopilot speaks but sends no telemetry: tick \"enable API control\" in DJI's assistant and set the "
        "telemetry rates there"},
    VerdictRow{Verdict::kWrongBaud, "wrong_baud", 3,
               "bytes arrive, but no frame: set the baud rate that DJI's assistant shows, and check that this is the "
               "autopilot's port"},
    VerdictRow{Verdict::kNoAutopilot, "no_autopilot", 3,
               "bytes arrive undamaged, but no frame: another device speaks at this rate; check that this is the "
               "autopilot's port"},
    VerdictRow{Verdict::kNoisy, "noisy", 1,
               "frames arrive, but many are damaged: shorten or shield the cable, check the common ground, close other "
               "programs on this port"},
    VerdictRow{
        Verdict::kOverrun, "overrun", 1,
        "frames arrive, but this machine takes its bytes too late: lower the telemetry rates in DJI's assistant, "
        "and close other programs"},
    VerdictRow{Verdict::kLineHeldLow, "line_held_low", 4,
               "the line is held low: switch the autopilot on, and check that RX, TX and ground are not exchanged or "
               "shorted"},
    VerdictRow{Verdict::kPosePort, "pose_port", 2,
               "MAVLink poses come at this port: --port and --pose-port are exchanged, or the adapters changed their "
               "names"},
    VerdictRow{Verdict::kNothingReceived, "nothing_received", 4,
               "not one byte: switch the aircraft on, cross RX and TX at UART_CAN2, and tick \"enable API control\" in "
               "DJI's assistant"},
    VerdictRow{Verdict::kCannotOpen, "cannot_open", 5, "the port cannot be opened: m100 doctor tells why"},
};

const VerdictRow& row_of(Verdict verdict) {
  const VerdictRow& row = kVerdicts[static_cast<std::size_t>(verdict)];
  M100_ASSERT(row.verdict == verdict);
  return row;
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
  const protocol::Telemetry former = telemetry_;
  if (protocol::decode_telemetry(value, telemetry_) == core::Status::kOk) {
    ++fit_m100_;
    (void)link::reject_non_finite(telemetry_, former);
  }
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

std::string_view name(Verdict verdict) { return row_of(verdict).name; }
int rank(Verdict verdict) { return row_of(verdict).rank; }
std::string_view remedy(Verdict verdict) { return row_of(verdict).remedy; }

std::string_view name(Firmware firmware) {
  constexpr std::array<std::string_view, 4> kNames{"unknown", "M100, firmware 3.1", "M100, firmware 2.3",
                                                   "not an M100, or another firmware"};
  return kNames[static_cast<std::size_t>(firmware)];
}

}  // namespace m100::companion
