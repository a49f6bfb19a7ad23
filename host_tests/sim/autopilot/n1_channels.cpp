// SPDX-License-Identifier: BSD-3-Clause
// Commands without an answer: the two command channels.
#include <algorithm>

#include "host_tests/sim/autopilot/n1_autopilot.h"

namespace m100::sim {
namespace {

constexpr std::uint32_t kVirtualRcMost_per_s = 25;
constexpr std::uint32_t kMovementMost_per_s = 50;

}  // namespace

std::uint32_t N1Autopilot::RateCounter::count(core::TimePoint now) {
  times_[count_ % kDepth] = now;
  ++count_;
  std::uint32_t within = 0;
  while (within < std::min(count_, kDepth) && now - times_[(count_ - 1 - within) % kDepth] < std::chrono::seconds(1)) {
    ++within;
  }
  return within;
}

void N1Autopilot::execute_unanswered(const protocol::Command& command, protocol::MessageId id) {
  // Sets 0x04 and 0x05 are ignored before activation [inferred]; session 0 cannot report that.
  if (!activated_) {
    emit("ignored", protocol::name(id));
    return;
  }
  if (const auto* movement = std::get_if<protocol::Movement>(&command)) {
    take_movement(*movement);
  } else if (const auto* wanted = std::get_if<protocol::VirtualRcSwitch>(&command)) {
    switch_virtual_rc(*wanted);
  } else if (const auto* data = std::get_if<protocol::VirtualRcData>(&command)) {
    take_virtual_rc(*data);
  } else {
    emit("received", protocol::name(id));
  }
}

std::uint32_t N1Autopilot::count_control_frame(RateCounter& watch, bool obeyed) {
  const std::uint32_t per_s = watch.count(time_);
  record_.max_commands_per_s = std::max(record_.max_commands_per_s, per_s);
  if (authority_lost_ && !obeyed) {
    ++record_.control_after_loss;
    record_.latest_after_loss = std::max(record_.latest_after_loss, time_ - lost_at_);
  }
  return per_s;
}

void N1Autopilot::switch_virtual_rc(const protocol::VirtualRcSwitch& wanted) {
  emit("received", "vrc_switch", wanted.on ? 1.0 : 0.0);
  if (!wanted.on) {
    virtual_rc_on_ = false;  // requested, so not a loss
    return;
  }
  ++record_.virtual_rc_on_requests;
  if (record_.virtual_rc_on_requests > 1) {
    record_.min_on_spacing = std::min(record_.min_on_spacing, time_ - last_on_);
    if (time_ - last_on_ < kSwitchSpacing) {
      switch_ignored_until_ = time_ + kSwitchSpacing;
      emit("received", "violation_virtual_rc_on_too_often", core::seconds<double>(time_ - last_on_));
    }
  }
  last_on_ = time_;
  const bool is_without_control = config_.behaviour.virtual_rc.needs_control && !client_in_control();
  if (!rc_in_f() || is_without_control) {  // [inferred]: leaving F ends Virtual RC, so it cannot begin outside of F
    emit("ignored", "vrc_switch");
    return;
  }
  if (!virtual_rc_on_) {
    virtual_rc_.channels.fill(protocol::kStickCentre_counts);
    virtual_rc_.channels[protocol::vrc_channel::kGear] = protocol::kGearDown_counts;
  }
  virtual_rc_on_ = true;
  authority_lost_ = false;
  virtual_rc_falls_back_ = wanted.fall_back_to_rc;
  last_virtual_rc_ = time_;
}

void N1Autopilot::take_virtual_rc(const protocol::VirtualRcData& data) {
  const std::uint32_t per_s = count_control_frame(virtual_rc_watch_, virtual_rc_on_);
  if (per_s > kVirtualRcMost_per_s + 1) {
    emit("received", "violation_virtual_rc_too_fast", per_s);
  }
  const bool right_id = !data.under_switch_id || config_.behaviour.virtual_rc.data_under_switch_id;
  if (!virtual_rc_on_ || !right_id || protocol::check(data) != core::Status::kOk) {
    ++record_.virtual_rc_ignored;
    emit("ignored", "vrc_data", data.under_switch_id ? 1.0 : 0.0);
    return;
  }
  ++record_.virtual_rc_taken;
  virtual_rc_ = data;
  last_virtual_rc_ = time_;
  emit("received", "vrc_data", virtual_rc_.channels[protocol::vrc_channel::kRoll]);
}

void N1Autopilot::take_movement(const protocol::Movement& movement) {
  const std::uint32_t per_s = count_control_frame(movement_watch_, client_in_control());
  if (per_s > kMovementMost_per_s + 1) {
    emit("received", "violation_movement_too_fast", per_s);
  }
  if (!client_in_control() || protocol::check(movement) != core::Status::kOk) {  // also a mode that does not exist
    ++record_.movement_ignored;
    emit("ignored", "movement", movement.flag);
    return;
  }
  ++record_.movement_taken;
  moving_ = true;
  last_movement_ = time_;
  movement_.set(movement, vehicle_.state());
  emit("received", "movement", movement.flag);
}

}  // namespace m100::sim
