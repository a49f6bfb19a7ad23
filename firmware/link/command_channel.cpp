// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/command_channel.h"

#include "firmware/core/maths.h"

namespace m100::link {
namespace {

struct RateWindow {
  double low_hz;
  double high_hz;
  double default_hz;
};
constexpr RateWindow kVirtualRcWindow{.low_hz = 5.0, .high_hz = 25.0, .default_hz = 25.0};  // protocol, section 7
constexpr RateWindow kMovementWindow{.low_hz = 1.0, .high_hz = 50.0, .default_hz = 50.0};   // protocol, 6.4
constexpr core::Duration kPaperPeriod = std::chrono::milliseconds(10);                      // paper, IV-B

}  // namespace

core::Expected<core::Duration> command_period(const ChannelConfig& config) {
  if (config.paper_100_hz) {
    return kPaperPeriod;
  }
  const RateWindow& window = config.channel == Channel::kVirtualRc ? kVirtualRcWindow : kMovementWindow;
  const double rate_hz = config.rate_hz == 0.0 ? window.default_hz : config.rate_hz;
  if (!(rate_hz >= window.low_hz && rate_hz <= window.high_hz)) {
    return core::Status::kOutOfRange;
  }
  // Rounded up, so that rounding never makes the rate higher than requested.
  const auto period_us = static_cast<core::Duration::rep>(1e6 / rate_hz);
  return core::Duration{static_cast<double>(period_us) * rate_hz < 1e6 ? period_us + 1 : period_us};
}

protocol::VirtualRcData to_virtual_rc(const vrc::Sticks& sticks) {
  protocol::VirtualRcData data;
  data.channels.fill(protocol::kStickCentre_counts);
  data.channels[protocol::vrc_channel::kRoll] = static_cast<std::uint32_t>(sticks.roll);
  data.channels[protocol::vrc_channel::kPitch] = static_cast<std::uint32_t>(sticks.pitch);
  data.channels[protocol::vrc_channel::kThrottle] = static_cast<std::uint32_t>(sticks.throttle);
  data.channels[protocol::vrc_channel::kYaw] = static_cast<std::uint32_t>(sticks.yaw);
  data.channels[protocol::vrc_channel::kGear] = protocol::kGearDown_counts;
  data.channels[protocol::vrc_channel::kMode] = protocol::kModeA_counts;
  return data;
}

protocol::Movement to_movement(const ctl::Command<double>& command) {
  constexpr protocol::MovementMode kMode{.horizontal = protocol::HorizontalMode::kAngle,
                                         .vertical = protocol::VerticalMode::kVelocity,
                                         .yaw = protocol::YawMode::kRate,
                                         .frame = protocol::HorizontalFrame::kBody,
                                         .stable = false};
  static_assert(protocol::movement_flag(kMode) == 0x0A);
  return {.flag = protocol::movement_flag(kMode),
          .x = static_cast<float>(core::clamp(command.roll_rad * core::kRadian_deg, -30.0, 30.0)),
          .y = static_cast<float>(core::clamp(-command.pitch_rad * core::kRadian_deg, -30.0, 30.0)),
          .z = static_cast<float>(core::clamp(command.climb_m_s, -4.0, 4.0)),
          .yaw = static_cast<float>(core::clamp(-command.yaw_rate_rad_s * core::kRadian_deg, -100.0, 100.0))};
}

}  // namespace m100::link
