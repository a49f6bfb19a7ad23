// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/autopilot/control/n1_virtual_rc.h"

#include "host_tests/sim/autopilot/control/n1_transmitter.h"

namespace m100::sim {

namespace channel = protocol::vrc_channel;

void N1VirtualRc::switch_to(const protocol::VirtualRcSwitch& wanted, bool may_begin) {
  if (!wanted.on) {
    on_ = false;  // requested, so not a loss
    return;
  }
  if (!may_begin) {
    log_.emit("ignored", "vrc_switch");
    return;
  }
  if (!on_) {
    data_.channels.fill(protocol::kStickCentre_counts);
    data_.channels[channel::kGear] = protocol::kGearDown_counts;
  }
  on_ = true;
  record_.clear_loss();
  falls_back_ = wanted.fall_back_to_rc;
  last_data_ = log_.now();
}

void N1VirtualRc::update(const protocol::VirtualRcData& data) {
  record_.count_virtual_rc_frame(on_);
  const bool right_id = !data.under_switch_id || how_.data_under_switch_id;
  if (!on_ || !right_id || protocol::check(data) != core::Status::kOk) {
    ++record_.counts().virtual_rc_ignored;
    log_.emit("ignored", "vrc_data", data.under_switch_id ? 1.0 : 0.0);
    return;
  }
  ++record_.counts().virtual_rc_taken;
  data_ = data;
  last_data_ = log_.now();
  log_.emit("received", "vrc_data", data_.channels[channel::kRoll]);
}

std::string_view N1VirtualRc::late() const {
  if (!on_ || log_.now() - last_data_ <= duration_of_seconds(how_.timeout_s)) {
    return "";
  }
  return falls_back_ ? "virtual_rc_silent" : "virtual_rc_silent_failsafe";
}

bool N1VirtualRc::end(std::string_view why) {
  if (!on_) {
    return false;
  }
  record_.count_loss(true);
  on_ = false;
  log_.emit("did", why);
  return true;
}

StickInput N1VirtualRc::sticks() const {
  constexpr double kFull_counts = 660.0;
  const auto counts = [this](std::size_t index, double sign) {
    const double from_centre = static_cast<double>(data_.channels[index]) - protocol::kStickCentre_counts;
    return protocol::kStickCentre_counts + sign * from_centre * kFull_counts / how_.full_deflection_counts;
  };
  return {.roll_vrc = counts(channel::kRoll, how_.roll_sign),
          .pitch_vrc = counts(channel::kPitch, how_.pitch_sign),
          .throttle_vrc = counts(channel::kThrottle, how_.throttle_sign),
          .yaw_vrc = counts(channel::kYaw, how_.yaw_sign)};
}

protocol::Telemetry::Rc N1VirtualRc::rc_item() const {
  const auto value = [this](std::size_t index) { return rc_value(static_cast<double>(data_.channels[index])); };
  const auto inverted = [&](std::size_t index) { return static_cast<std::int16_t>(-value(index)); };
  return {.roll = value(channel::kRoll),
          .pitch = value(channel::kPitch),
          .yaw = value(channel::kYaw),
          .throttle = value(channel::kThrottle),
          .mode = inverted(channel::kMode),
          .gear = inverted(channel::kGear)};
}

}  // namespace m100::sim
