// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/autopilot/n1_client_record.h"

#include <algorithm>

namespace m100::sim {
namespace {

constexpr std::uint32_t kMaxVirtualRc_per_s = 25;
constexpr std::uint32_t kMaxMovement_per_s = 50;

}  // namespace

std::uint32_t N1ClientRecord::RateCounter::count(core::TimePoint now) {
  times_[count_ % kDepth] = now;
  ++count_;
  std::uint32_t within = 0;
  while (within < std::min(count_, kDepth) && now - times_[(count_ - 1 - within) % kDepth] < std::chrono::seconds(1)) {
    ++within;
  }
  return within;
}

void N1ClientRecord::count_obtain_request() {
  ++record_.obtain_requests;
  if (record_.obtain_requests > 1) {
    record_.min_obtain_spacing = std::min(record_.min_obtain_spacing, log_.now() - last_obtain_);
  }
  last_obtain_ = log_.now();
}

bool N1ClientRecord::count_virtual_rc_on_request() {
  ++record_.virtual_rc_on_requests;
  const core::Duration spacing = log_.now() - last_on_;
  last_on_ = log_.now();
  if (record_.virtual_rc_on_requests == 1) {
    return false;
  }
  record_.min_on_spacing = std::min(record_.min_on_spacing, spacing);
  if (spacing < kSwitchSpacing) {
    log_.emit("received", "violation_virtual_rc_on_too_often", core::seconds<double>(spacing));
  }
  return spacing < kSwitchSpacing;
}

void N1ClientRecord::count_virtual_rc_frame(bool obeyed) {
  const std::uint32_t per_s = virtual_rc_rate_.count(log_.now());
  count_control_frame(per_s, obeyed);
  if (per_s > kMaxVirtualRc_per_s + 1) {
    log_.emit("received", "violation_virtual_rc_too_fast", per_s);
  }
}

void N1ClientRecord::count_movement_frame(bool obeyed) {
  const std::uint32_t per_s = movement_rate_.count(log_.now());
  count_control_frame(per_s, obeyed);
  if (per_s > kMaxMovement_per_s + 1) {
    log_.emit("received", "violation_movement_too_fast", per_s);
  }
}

void N1ClientRecord::count_control_frame(std::uint32_t per_s, bool obeyed) {
  record_.max_commands_per_s = std::max(record_.max_commands_per_s, per_s);
  if (authority_lost_ && !obeyed) {
    ++record_.control_after_loss;
    record_.latest_after_loss = std::max(record_.latest_after_loss, log_.now() - lost_at_);
  }
}

void N1ClientRecord::count_loss(bool client_commanded) {
  if (client_commanded && !authority_lost_) {
    authority_lost_ = true;
    lost_at_ = log_.now();
    ++record_.losses;
  }
}

}  // namespace m100::sim
