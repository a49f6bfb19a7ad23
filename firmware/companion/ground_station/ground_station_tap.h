// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "firmware/companion/ground_station/mavlink_tap.h"
#include "firmware/companion/ground_station/requests.h"
#include "protocol/mavlink/command_messages.h"

namespace m100::companion {

/// Counts of messages from the ground station.
struct GroundStationStats {
  std::uint32_t goals = 0;
  std::uint32_t orders = 0;
  std::uint32_t requests = 0;
  std::uint32_t orders_lost = 0;    ///< because kMaxCommands waited already; or they lost their place to another
  std::uint32_t requests_lost = 0;  ///< because kMaxAnswers came before in that tick
};

inline constexpr std::uint16_t kGuidedEnable = 92;  ///< MAV_CMD_NAV_GUIDED_ENABLE: param1 1 engage, 0 release
inline constexpr std::uint16_t kPauseContinue =
    193;  ///< MAV_CMD_DO_PAUSE_CONTINUE: param1 0 hold; 1, to go on, is refused

constexpr bool is_hold_command(const mavlink::CommandLong& order) {
  return order.command == kPauseContinue && order.param1 < 0.5F;
}

/// A line that passes all bytes on, and keeps the newest goal of each sender, the first kMaxCommands orders and the
/// answers to the first kMaxAnswers requests that passed. Without room for it, an order to release replaces the last
/// waiting order; an order to hold replaces it unless it is a release. No heap.
class GroundStationTap final : public MavlinkTap {
 public:
  /// A goal or set point and who gave it.
  struct Goal {
    mavlink::SetPositionTargetLocalNed message;
    mavlink::Address from;
  };
  /// An order and who gave it.
  struct Order {
    mavlink::CommandLong message;
    mavlink::Address from;
  };

  static constexpr std::size_t kMaxSenders = 2;   ///< of goals in one tick: one that is flown, one that is refused
  static constexpr std::size_t kMaxCommands = 4;  ///< waiting orders: a release waits for at most three ticks
  static constexpr std::size_t kMaxAnswers = 8;   ///< in one tick

  /// @param only whose set points count on a line without signatures, whose orders are all refused; nullopt: the line
  ///   passes authorised senders only, and all of them count.
  explicit GroundStationTap(hal::Uart& line, std::optional<mavlink::Address> only = {})
      : MavlinkTap(line), only_(only) {}

  bool is_signed() const { return !only_; }
  /// Whether a goal came from a sender whose goals do not count, since the last call.
  bool take_stranger() { return std::exchange(stranger_, false); }
  /// A goal for us, its sender's newest; in the order in which the senders came.
  std::optional<Goal> take_goal() {
    if (goal_count_ == 0) {
      return std::nullopt;
    }
    const Goal first = goals_[0];
    std::shift_left(goals_.begin(), goals_.begin() + static_cast<std::ptrdiff_t>(goal_count_--), 1);
    return first;
  }
  /// The order for us that has waited longest.
  std::optional<Order> take_order() {
    if (order_count_ == 0) {
      return std::nullopt;
    }
    const Order first = orders_[0];
    std::shift_left(orders_.begin(), orders_.begin() + static_cast<std::ptrdiff_t>(order_count_--), 1);
    return first;
  }
  /// The answers to the requests since clear_answers(), in order of arrival.
  std::span<const Reply> answers() const { return std::span(answers_).first(answer_count_); }
  void clear_answers() { answer_count_ = 0; }
  const GroundStationStats& stats() const { return stats_; }

 private:
  /// We are system 1; 0 addresses all systems.
  static bool is_for_us(std::uint8_t system) { return system <= 1; }
  void receive(const mavlink::FrameView& frame) override {
    if (mavlink::is<mavlink::SetPositionTargetLocalNed>(frame)) {
      if (const auto goal = mavlink::decode<mavlink::SetPositionTargetLocalNed>(frame); is_for_us(goal.target_system)) {
        store(Goal{goal, frame.from});
      }
    } else if (mavlink::is<mavlink::CommandLong>(frame)) {
      const auto order = mavlink::decode<mavlink::CommandLong>(frame);
      if (is_for_us(order.target_system)) {
        store(Order{order, frame.from});
        ++stats_.orders;
      }
    } else {
      answer_if<mavlink::ParamRequestList>(frame);
      answer_if<mavlink::ParamRequestRead>(frame);
      answer_if<mavlink::MissionRequestList>(frame);
      answer_if<mavlink::MissionCount>(frame);
      answer_if<mavlink::MissionWritePartialList>(frame);
      answer_if<mavlink::MissionClearAll>(frame);
    }
  }
  void store(const Goal& goal) {
    if (only_ && goal.from != *only_) {
      stranger_ = true;
      return;
    }
    ++stats_.goals;
    const auto stored = std::span(goals_).first(goal_count_);
    const auto same =
        std::find_if(stored.begin(), stored.end(), [&](const Goal& one) { return one.from == goal.from; });
    if (same != stored.end()) {
      *same = goal;
    } else if (goal_count_ < kMaxSenders) {
      goals_[goal_count_++] = goal;
    }
  }
  static bool releases(const Order& order) {
    return order.message.command == kGuidedEnable && !(order.message.param1 >= 0.5F);
  }
  /// An order that finds no room and replaces none is not answered, so its sender repeats it.
  void store(const Order& order) {
    if (order_count_ < kMaxCommands) {
      orders_[order_count_++] = order;
      return;
    }
    ++stats_.orders_lost;
    if (releases(order) || (is_hold_command(order.message) && !releases(orders_.back()))) {
      orders_.back() = order;
    }
  }
  template <typename Request>
  void answer_if(const mavlink::FrameView& frame) {
    if (!mavlink::is<Request>(frame)) {
      return;
    }
    const auto request = mavlink::decode<Request>(frame);
    if (!is_for_us(request.target_system)) {
      return;
    }
    ++stats_.requests;
    const std::optional<Reply> answer = answer_to(request, frame.from);
    if (answer && answer_count_ == kMaxAnswers) {
      ++stats_.requests_lost;
    } else if (answer) {
      answers_[answer_count_++] = *answer;
    }
  }

  std::optional<mavlink::Address> only_;
  bool stranger_ = false;
  std::array<Goal, kMaxSenders> goals_{};
  std::size_t goal_count_ = 0;
  std::array<Order, kMaxCommands> orders_{};  ///< waiting orders, the oldest first
  std::size_t order_count_ = 0;
  std::array<Reply, kMaxAnswers> answers_{};
  std::size_t answer_count_ = 0;
  GroundStationStats stats_;
};

}  // namespace m100::companion
