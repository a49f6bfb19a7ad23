// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

#include "firmware/companion/room/requests.h"
#include "hal/uart.h"
#include "protocol/mavlink/order_messages.h"
#include "protocol/mavlink/parser.h"

namespace m100::companion {

/// What a room has said to us so far.
struct HeardStats {
  std::uint32_t goals = 0;
  std::uint32_t orders = 0;
  std::uint32_t requests = 0;
  std::uint32_t orders_replaced = 0;  ///< by a newer one of the same tick
  std::uint32_t requests_lost = 0;    ///< more than kMostRequests came in a tick
};

/// A line that hands on everything, and keeps the newest goal, the newest order and the first kMostRequests requests
/// that passed. Put in front of a signed line it hears only who may speak. No heap; costs one parser more.
class OverheardLine final : public hal::Uart {
 public:
  /// An order and who gave it.
  struct Order {
    mavlink::CommandLong message;
    mavlink::Address from;
  };

  explicit OverheardLine(hal::Uart& line) : line_(line) {}

  core::Expected<std::size_t> read(std::span<std::byte> destination) override {
    const core::Expected<std::size_t> count = line_.read(destination);
    if (count && *count > 0) {
      parser_.consume(std::span<const std::byte>(destination).first(*count),
                      [this](const mavlink::FrameView& frame) { hear(frame); });
    }
    return count;
  }
  core::Expected<std::size_t> write(std::span<const std::byte> source) override { return line_.write(source); }
  core::Expected<hal::LineErrors> line_errors() const override { return line_.line_errors(); }

  /// What came since the call before, if it is for us.
  std::optional<mavlink::SetPositionTargetLocalNed> take_goal() { return std::exchange(goal_, std::nullopt); }
  std::optional<Order> take_order() { return std::exchange(order_, std::nullopt); }
  /// What was asked since forget_requests(), in its order.
  std::span<const Request> requests() const { return requests_.all(); }
  void forget_requests() { requests_.clear(); }
  const HeardStats& stats() const { return stats_; }

 private:
  /// We are system 1; 0 is everybody.
  static bool is_for_us(std::uint8_t system) { return system <= 1; }
  void hear(const mavlink::FrameView& frame) {
    if (mavlink::is<mavlink::SetPositionTargetLocalNed>(frame)) {
      if (const auto goal = mavlink::decode<mavlink::SetPositionTargetLocalNed>(frame); is_for_us(goal.target_system)) {
        goal_ = goal;
        ++stats_.goals;
      }
    } else if (mavlink::is<mavlink::CommandLong>(frame)) {
      if (const auto order = mavlink::decode<mavlink::CommandLong>(frame); is_for_us(order.target_system)) {
        stats_.orders_replaced += order_ ? 1U : 0U;
        order_ = Order{order, frame.from};
        ++stats_.orders;
      }
    } else {
      hear_request(frame, std::type_identity<RequestMessage>{});
    }
  }
  template <typename... Message>
  void hear_request(const mavlink::FrameView& frame, std::type_identity<std::variant<Message...>>) {
    (hear_if<Message>(frame), ...);
  }
  template <typename Message>
  void hear_if(const mavlink::FrameView& frame) {
    if (!mavlink::is<Message>(frame)) {
      return;
    }
    if (const auto message = mavlink::decode<Message>(frame); is_for_us(message.target_system)) {
      ++stats_.requests;
      stats_.requests_lost += requests_.add({message, frame.from}) ? 0U : 1U;
    }
  }

  hal::Uart& line_;
  mavlink::Parser parser_;
  std::optional<mavlink::SetPositionTargetLocalNed> goal_;
  std::optional<Order> order_;
  Requests requests_;
  HeardStats stats_;
};

}  // namespace m100::companion
