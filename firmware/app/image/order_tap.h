// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "hal/uart.h"
#include "protocol/dji/order_message.h"

namespace m100::app {

/// An order of a board's operator.
enum class Order : std::uint8_t { kNone, kEngage, kRelease };

/// Turns the position of a switch, wired to a pin or sent in messages, into orders. Only its movement is an order: if
/// the switch is on when the board starts, nothing is ordered until it has been off.
class OrderSwitch {
 public:
  /// @returns kEngage: it was turned on after it had been off. kRelease: it was turned off. kNone: it did not move, or
  ///   was on from the start.
  Order set(bool program_flies) {
    const Order order = program_flies == on_ ? Order::kNone : (program_flies ? Order::kEngage : Order::kRelease);
    on_ = program_flies;
    return order;
  }

 private:
  bool on_ = true;  ///< until seen off, so that "on" is no movement
};

/// The pose's UART, which also carries the operator's switch: passes all bytes through and records the orders in them.
/// Line is the UART's own type: a call through the interface to itself would look like recursion in the stack analysis.
template <typename Line>
class OrderTap final : public hal::Uart {
 public:
  /// @param line must outlive this.
  explicit OrderTap(Line& line) : line_(line) {}

  core::Expected<std::size_t> read(std::span<std::byte> destination) override {
    const core::Expected<std::size_t> count = line_.read(destination);
    for (const std::byte value : destination.first(count.value_or(0))) {
      const core::Expected<bool> position = parser_.push(value);
      const Order order = position ? switch_.set(*position) : Order::kNone;
      record(order);
    }
    return count;
  }
  core::Expected<std::size_t> write(std::span<const std::byte> source) override { return line_.write(source); }
  core::Expected<hal::LineErrors> line_errors() const override { return line_.line_errors(); }

  /// @returns an order that was not taken yet, kRelease before kEngage; kNone: there is none. An order to stop is never
  ///   lost, and it cancels an earlier order to fly.
  Order take() {
    if (std::exchange(releases_, false)) {
      return Order::kRelease;
    }
    return std::exchange(engages_, false) ? Order::kEngage : Order::kNone;
  }

 private:
  void record(Order order) {
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
