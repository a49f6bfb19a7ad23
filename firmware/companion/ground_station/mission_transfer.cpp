// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/ground_station/mission_transfer.h"

#include <cmath>

namespace m100::companion {
namespace {

// Numbers of MAVLink's common message set.
constexpr std::uint16_t kNavWaypoint = 16;  // MAV_CMD
constexpr std::uint8_t kLocalNed = 1;       // MAV_FRAME
constexpr std::uint8_t kFlightPlan = 0;     // MAV_MISSION_TYPE; others are fences and rally points

constexpr std::int32_t kFarthest = 10'000'000;  // 1 km in 0.1 mm
constexpr float kFarthest_m = 1000.F;
constexpr float kLongestHold_s = 3600.F;
constexpr float kLargestRadius_m = 100.F;
constexpr float kMaxTurn_deg = 3600.F;

/// NaN means that the vehicle chooses the value.
bool is_unset_or(float value, float low, float high) { return std::isnan(value) || (value >= low && value <= high); }
bool is_within(std::int32_t value) { return value >= -kFarthest && value <= kFarthest; }

std::int32_t in_tenths_of_mm(float value_m) {
  const bool is_near = std::abs(value_m) <= kFarthest_m;  // false for NaN
  return is_near ? static_cast<std::int32_t>(std::lround(1e4 * static_cast<double>(value_m))) : kFarthest + 1;
}

mavlink::MissionAck ack(mavlink::Address to, std::uint8_t result, std::uint8_t type = kFlightPlan) {
  return {.target_system = to.system, .target_component = to.component, .type = result, .mission_type = type};
}

/// Refuses MAVLink's fence and rally points. @returns true: the request was of such a type and has been answered.
template <typename Message>
bool is_other_type(const Message& message, mavlink::Address from, Replies& replies) {
  if (message.mission_type == kFlightPlan) {
    return false;
  }
  (void)replies.add(ack(from, mission_result::kUnsupported, message.mission_type));
  return true;
}

}  // namespace

mavlink::MissionItemInt to_item_int(const mavlink::MissionItem& item) {
  return {.param1 = item.param1,
          .param2 = item.param2,
          .param3 = item.param3,
          .param4 = item.param4,
          .x = in_tenths_of_mm(item.x),
          .y = in_tenths_of_mm(item.y),
          .z = item.z,
          .seq = item.seq,
          .command = item.command,
          .target_system = item.target_system,
          .target_component = item.target_component,
          .frame = item.frame,
          .current = item.current,
          .autocontinue = item.autocontinue,
          .mission_type = item.mission_type};
}

std::uint8_t validate(const mavlink::MissionItemInt& item) {
  if (item.command != kNavWaypoint) {
    return mission_result::kUnsupported;
  }
  if (item.frame != kLocalNed) {
    return mission_result::kUnsupportedFrame;
  }
  if (!is_unset_or(item.param1, 0.F, kLongestHold_s)) {
    return mission_result::kInvalidParam1;
  }
  if (!is_unset_or(item.param2, 0.F, kLargestRadius_m)) {
    return mission_result::kInvalidParam2;
  }
  if (!is_unset_or(item.param3, 0.F, 0.F)) {
    return mission_result::kInvalidParam3;
  }
  if (!is_unset_or(item.param4, -kMaxTurn_deg, kMaxTurn_deg)) {
    return mission_result::kInvalidParam4;
  }
  if (!is_within(item.x) || !is_within(item.y)) {
    return is_within(item.x) ? mission_result::kInvalidY : mission_result::kInvalidX;
  }
  const bool has_height = std::isfinite(item.z) && std::abs(item.z) <= kFarthest_m;
  return has_height ? mission_result::kAccepted : mission_result::kInvalidZ;
}

void MissionTransfer::receive(const Request& request, bool is_flown, core::TimePoint now, Replies& replies) {
  const mavlink::Address from = request.from;
  if (const auto* const announced = std::get_if<mavlink::MissionCount>(&request.message)) {
    take(*announced, from, is_flown, now, replies);
  } else if (const auto* const item = std::get_if<mavlink::MissionItemInt>(&request.message)) {
    take(*item, from, is_flown, now, replies);
  } else if (const auto* const older = std::get_if<mavlink::MissionItem>(&request.message)) {
    take(to_item_int(*older), from, is_flown, now, replies);
  } else if (const auto* const list = std::get_if<mavlink::MissionRequestList>(&request.message)) {
    send_count(*list, from, replies);
  } else if (const auto* const asked = std::get_if<mavlink::MissionRequestInt>(&request.message)) {
    send_item(*asked, from, replies);
  } else if (const auto* const asked_of_old = std::get_if<mavlink::MissionRequest>(&request.message)) {
    send_item({.seq = asked_of_old->seq, .mission_type = asked_of_old->mission_type}, from, replies);
  } else if (const auto* const end = std::get_if<mavlink::MissionAck>(&request.message)) {
    expected_ = end->type == mission_result::kCancelled && from == partner_ ? 0 : expected_;
  } else if (const auto* const erased = std::get_if<mavlink::MissionClearAll>(&request.message)) {
    clear(*erased, from, is_flown, replies);
  }
}

void MissionTransfer::send_count(const mavlink::MissionRequestList& list, mavlink::Address from,
                                 Replies& replies) const {
  if (!is_other_type(list, from, replies)) {
    (void)replies.add(mavlink::MissionCount{
        .count = static_cast<std::uint16_t>(count_), .target_system = from.system, .target_component = from.component});
  }
}

void MissionTransfer::clear(const mavlink::MissionClearAll& erased, mavlink::Address from, bool is_flown,
                            Replies& replies) {
  if (is_other_type(erased, from, replies)) {
    return;
  }
  const bool may = !is_flown && (!is_open() || from == partner_);
  if (may) {
    replace(0);
    end_.reset();
  }
  (void)replies.add(ack(from, may ? mission_result::kAccepted : mission_result::kDenied));
}

void MissionTransfer::replace(std::size_t count) {
  current_ = 1 - current_;
  count_ = count;
  expected_ = 0;
  ++edition_;
}

void MissionTransfer::take(const mavlink::MissionCount& announced, mavlink::Address from, bool is_flown,
                           core::TimePoint now, Replies& replies) {
  if (is_other_type(announced, from, replies)) {
    return;
  }
  if (is_flown || (is_open() && !(from == partner_)) || announced.count > kMaxItems) {
    const bool fits = announced.count <= kMaxItems;
    (void)replies.add(ack(from, fits ? mission_result::kDenied : mission_result::kNoSpace));
    return;
  }
  partner_ = from;
  next_ = 0;
  request_count_ = 0;
  end_.reset();
  expected_ = announced.count;
  if (expected_ == 0) {
    replace(0);
    (void)replies.add(ack(from, mission_result::kAccepted));
    return;
  }
  request_item(now, replies);
}

void MissionTransfer::take(const mavlink::MissionItemInt& item, mavlink::Address from, bool is_flown,
                           core::TimePoint now, Replies& replies) {
  if (!(from == partner_) || item.mission_type != kFlightPlan) {
    return;
  }
  if (!is_open()) {
    if (end_ && item.seq == end_->seq) {
      (void)replies.add(ack(from, end_->result));
    }
    return;
  }
  if (item.seq != next_) {
    return;  // a duplicate; a missing item is requested again by tick()
  }
  if (is_flown) {  // the mission's flight began after the new list was announced
    finish(item, mission_result::kDenied, replies);
    return;
  }
  if (const std::uint8_t result = validate(item); result != mission_result::kAccepted) {
    finish(item, result, replies);
    return;
  }
  lists_[1 - current_][next_++] = item;
  request_count_ = 0;
  if (next_ < expected_) {
    request_item(now, replies);
    return;
  }
  replace(next_);
  finish(item, mission_result::kAccepted, replies);
}

void MissionTransfer::finish(const mavlink::MissionItemInt& item, std::uint8_t result, Replies& replies) {
  expected_ = 0;
  end_ = TransferResult{.seq = item.seq, .result = result};
  (void)replies.add(ack(partner_, result));
}

void MissionTransfer::send_item(const mavlink::MissionRequestInt& asked, mavlink::Address to, Replies& replies) const {
  if (is_other_type(asked, to, replies)) {
    return;
  }
  if (asked.seq >= count_) {
    (void)replies.add(ack(to, mission_result::kInvalidSequence));
    return;
  }
  mavlink::MissionItemInt item = lists_[current_][asked.seq];
  item.target_system = to.system;
  item.target_component = to.component;
  (void)replies.add(item);
}

void MissionTransfer::request_item(core::TimePoint now, Replies& replies) {
  requested_at_ = now;
  ++request_count_;
  (void)replies.add(mavlink::MissionRequestInt{
      .seq = next_, .target_system = partner_.system, .target_component = partner_.component});
}

void MissionTransfer::tick(core::TimePoint now, Replies& replies) {
  if (!is_open() || now - requested_at_ < kRetryInterval) {
    return;
  }
  if (request_count_ >= kMaxRequestsPerItem) {
    expected_ = 0;
    (void)replies.add(ack(partner_, mission_result::kCancelled));
    return;
  }
  request_item(now, replies);
}

}  // namespace m100::companion
