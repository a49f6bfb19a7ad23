// SPDX-License-Identifier: BSD-3-Clause
// Messages that the autopilot sends without a request: telemetry and other pushes, all in session 0.
#include <cmath>

#include "host_tests/sim/autopilot/n1_autopilot.h"
#include "protocol/dji/frame_encoder.h"

namespace m100::sim {
namespace {

constexpr std::int16_t kGearDown = -4545;
constexpr double kFullStick = 10000.0;
constexpr core::Duration kSlot = std::chrono::milliseconds(10);        // of telemetry
constexpr core::Duration kFinishingLanding = std::chrono::seconds(2);  // protocol, 8

std::int16_t rc_value(double counts) {
  return static_cast<std::int16_t>(std::lround((counts - protocol::kStickCentre_counts) * kFullStick / 660.0));
}

}  // namespace

std::int16_t rc_mode(N1Mode mode) {
  switch (mode) {
    case N1Mode::kF:
      return protocol::kRcModeF;
    case N1Mode::kP:
      return protocol::kRcModeP;
    case N1Mode::kA:
      break;
  }
  return protocol::kRcModeA;
}

protocol::FlightStatus N1Autopilot::flight_status() const {
  if (task_open_ && !task_done_) {
    return task_ == protocol::Task::kTakeOff ? protocol::FlightStatus::kTakingOff : protocol::FlightStatus::kLanding;
  }
  if (landed_at_ != core::TimePoint{} && time_ - landed_at_ < kFinishingLanding && !vehicle_.state().in_air) {
    return protocol::FlightStatus::kLanded;
  }
  return vehicle_.state().in_air ? protocol::FlightStatus::kInAir : protocol::FlightStatus::kStandby;
}

protocol::Telemetry::Rc N1Autopilot::rc_item() const {
  if (virtual_rc_on_ && config_.behaviour.virtual_rc.shown_in_rc_item) {
    const auto channel = [this](std::size_t index) {
      return rc_value(static_cast<double>(virtual_rc_.channels[index]));
    };
    const auto inverted = [&](std::size_t index) { return static_cast<std::int16_t>(-channel(index)); };
    return {.roll = channel(protocol::vrc_channel::kRoll),
            .pitch = channel(protocol::vrc_channel::kPitch),
            .yaw = channel(protocol::vrc_channel::kYaw),
            .throttle = channel(protocol::vrc_channel::kThrottle),
            .mode = inverted(protocol::vrc_channel::kMode),
            .gear = inverted(protocol::vrc_channel::kGear)};
  }
  if (!rc_on_) {
    return {};
  }
  return {.roll = rc_value(pilot_sticks_.roll_vrc),
          .pitch = rc_value(pilot_sticks_.pitch_vrc),
          .yaw = rc_value(pilot_sticks_.yaw_vrc),
          .throttle = rc_value(pilot_sticks_.throttle_vrc),
          .mode = rc_mode(wanted_mode_),  // position of the switch, even if the autopilot ignores it
          .gear = kGearDown};
}

void N1Autopilot::send_telemetry() {
  const std::uint16_t items = due_items(rates_, slot_);
  ++slot_;
  if (items == 0 || time_ < silent_until_) {
    return;
  }
  const auto ticks = static_cast<std::uint32_t>(ticks_ - booted_at_tick_);
  protocol::Telemetry telemetry = report(estimator_.update(vehicle_.estimated(), kSlot), ticks, config_.noise, random_);
  const double unit =
      N1Behaviour{}.telemetry.acceleration_unit_m_s2 / config_.behaviour.telemetry.acceleration_unit_m_s2;
  for (float& axis : telemetry.acceleration) {
    axis = static_cast<float>(static_cast<double>(axis) * unit);
  }
  telemetry.items = items;
  telemetry.rc = rc_item();
  telemetry.flight_status = flight_status();
  telemetry.control.mode = moving_ ? movement_.control_mode() : std::uint8_t{0};
  telemetry.control.bits =
      static_cast<std::uint8_t>(static_cast<unsigned>(device_) | (client_in_control() || requested_once_ ? 8U : 0U) |
                                (virtual_rc_on_ ? 16U : 0U));
  if (telemetry_fault_) {
    telemetry_fault_(telemetry);
  }
  push(protocol::ids::kTelemetry, encode(telemetry));
  ++record_.telemetry_packages;
}

void N1Autopilot::push(protocol::MessageId id, std::span<const std::byte> value) {
  std::array<std::byte, N1Line::kFrameBytes> space;
  const core::Expected<std::span<const std::byte>> frame = protocol::encode_frame(
      {.session = protocol::kUnansweredSession, .is_ack = false, .encrypted = false, .sequence = push_sequence_}, &id,
      value, space);
  ++push_sequence_;
  if (frame) {
    (void)line_.send(*frame, time_);
  }
}

}  // namespace m100::sim
