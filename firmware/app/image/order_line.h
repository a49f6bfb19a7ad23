// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "hal/uart.h"
#include "protocol/order_message.h"

namespace m100::app {

/// What the operator of a board asks for.
enum class Order : std::uint8_t { kNone, kEngage, kRelease };

/// Turns the position of a switch, wired to a pin or sent in messages, into orders. Only its movement is an order: a
/// board that starts, or starts again, with the switch already on does nothing until it has seen it off.
class OrderSwitch {
 public:
  /// @returns kEngage: it has been turned on, after it was seen off. kRelease: it is off. kNone: it is as it was, or on
  ///   from the start.
  Order set(bool program_flies) {
    const Order order = program_flies == on_ ? Order::kNone : (program_flies ? Order::kEngage : Order::kRelease);
    on_ = program_flies;
    return order;
  }

 private:
  bool on_ = true;  ///< until seen off, so that "on" is no movement
};

/// The pose's UART with an ear for the operator's switch: passes everything through, and notes the orders on the way.
/// Line is the UART's own type, so that one interface does not call through itself where the depth of calls is counted.
template <typename Line>
class OrderLine final : public hal::Uart {
 public:
  /// @param line must outlive this.
  explicit OrderLine(Line& line) : line_(line) {}

  core::Expected<std::size_t> read(std::span<std::byte> destination) override {
    const core::Expected<std::size_t> count = line_.read(destination);
    for (const std::byte value : destination.first(count.value_or(0))) {
      const core::Expected<bool> position = parser_.push(value);
      const Order order = position ? switch_.set(*position) : Order::kNone;
      note(order);
    }
    return count;
  }
  core::Expected<std::size_t> write(std::span<const std::byte> source) override { return line_.write(source); }
  core::Expected<hal::LineErrors> line_errors() const override { return line_.line_errors(); }

  /// @returns the movements of the switch that were not taken yet, the earliest first. To stop is never lost: behind it
  ///   there may be an order to fly, and in front of it none any more.
  Order take() {
    if (std::exchange(releases_, false)) {
      return Order::kRelease;
    }
    return std::exchange(engages_, false) ? Order::kEngage : Order::kNone;
  }

 private:
  void note(Order order) {
    releases_ = releases_ || order == Order::kRelease;
    engages_ = order == Order::kEngage || (engages_ && order == Order::kNone);
  }

  Line& line_;
  protocol::OrderParser parser_;
  OrderSwitch switch_;
  bool releases_ = false;
  bool engages_ = false;
};

}  // namespace m100::app
