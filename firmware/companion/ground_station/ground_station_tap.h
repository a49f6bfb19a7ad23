// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>
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
  std::uint32_t requests_lost = 0;  ///< because kMaxRequests came before in that tick
};

inline constexpr std::uint16_t kGuidedEnable = 92;    ///< MAV_CMD_NAV_GUIDED_ENABLE: param1 1 engage, 0 release
inline constexpr std::uint16_t kPauseContinue = 193;  ///< MAV_CMD_DO_PAUSE_CONTINUE: param1 0 hold, 1 go on

/// A line that passes all bytes on, and keeps the newest goal, the first kMaxCommands orders and the first kMaxRequests
/// requests that passed. Without room for it, an order to release replaces the last waiting order; an order to hold
/// replaces it unless it is a release. On a signed line it receives authorised senders only. No heap.
class GroundStationTap final : public MavlinkTap {
 public:
  /// An order and who gave it.
  struct Order {
    mavlink::CommandLong message;
    mavlink::Address from;
  };

  static constexpr std::size_t kMaxCommands = 4;  ///< waiting orders: a release waits for at most three ticks

  using MavlinkTap::MavlinkTap;

  /// The newest goal for us, and the order for us that has waited longest.
  std::optional<mavlink::SetPositionTargetLocalNed> take_goal() { return std::exchange(goal_, std::nullopt); }
  std::optional<Order> take_order() {
    if (order_count_ == 0) {
      return std::nullopt;
    }
    const Order first = orders_[0];
    std::shift_left(orders_.begin(), orders_.begin() + static_cast<std::ptrdiff_t>(order_count_--), 1);
    return first;
  }
  /// The requests since clear_requests(), in order of arrival.
  std::span<const Request> requests() const { return requests_.all(); }
  void clear_requests() { requests_.clear(); }
  const GroundStationStats& stats() const { return stats_; }

 private:
  /// We are system 1; 0 addresses all systems.
  static bool is_for_us(std::uint8_t system) { return system <= 1; }
  void receive(const mavlink::FrameView& frame) override {
    if (mavlink::is<mavlink::SetPositionTargetLocalNed>(frame)) {
      if (const auto goal = mavlink::decode<mavlink::SetPositionTargetLocalNed>(frame); is_for_us(goal.target_system)) {
        goal_ = goal;
        ++stats_.goals;
      }
    } else if (mavlink::is<mavlink::CommandLong>(frame)) {
      const auto order = mavlink::decode<mavlink::CommandLong>(frame);
      if (is_for_us(order.target_system)) {
        store({order, frame.from});
        ++stats_.orders;
      }
    } else {
      receive_request(frame, std::type_identity<RequestMessage>{});
    }
  }
  static bool releases(const Order& order) {
    return order.message.command == kGuidedEnable && !(order.message.param1 >= 0.5F);
  }
  static bool holds(const Order& order) {
    return order.message.command == kPauseContinue && order.message.param1 < 0.5F;
  }
  /// An order that finds no room and replaces none is not answered, so its sender repeats it.
  void store(const Order& order) {
    if (order_count_ < kMaxCommands) {
      orders_[order_count_++] = order;
      return;
    }
    ++stats_.orders_lost;
    if (releases(order) || (holds(order) && !releases(orders_.back()))) {
      orders_.back() = order;
    }
  }
  template <typename... Message>
  void receive_request(const mavlink::FrameView& frame, std::type_identity<std::variant<Message...>>) {
    (receive_if<Message>(frame), ...);
  }
  template <typename Message>
  void receive_if(const mavlink::FrameView& frame) {
    if (!mavlink::is<Message>(frame)) {
      return;
    }
    if (const auto message = mavlink::decode<Message>(frame); is_for_us(message.target_system)) {
      ++stats_.requests;
      stats_.requests_lost += requests_.add({message, frame.from}) ? 0U : 1U;
    }
  }

  std::optional<mavlink::SetPositionTargetLocalNed> goal_;
  std::array<Order, kMaxCommands> orders_{};  ///< waiting orders, the oldest first
  std::size_t order_count_ = 0;
  Requests requests_;
  GroundStationStats stats_;
};

}  // namespace m100::companion
