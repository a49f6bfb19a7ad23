// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/time.h"
#include "firmware/link/serial_link.h"
#include "firmware/log/records.h"
#include "firmware/safety/failsafe.h"
#include "firmware/safety/order_status.h"

namespace m100::app {

/// The operator's orders between two ticks, and the requests for control that follow from them. An order to fly is
/// valid until it is served, withdrawn, or too old. Control that is ours but not used goes back to the pilot.
class OperatorOrders {
 public:
  /// @param timeout how long an order to fly stays valid.
  explicit OperatorOrders(core::Duration timeout) : timeout_(timeout) {}

  /// Each takes effect in the next update(). @param order log::kOrder*.
  void add(std::uint32_t order) { given_ |= order; }
  /// Sends the request for one of the autopilot's own tasks. @returns as SerialLink::request.
  core::Status begin_task(protocol::Task task, link::SerialLink& link, core::TimePoint now);

  /// Once per tick, before the link receives. @param in_reach FlightConfig::reach_m; if false, "engage" has no effect.
  void update(bool in_reach, safety::FailsafeState failsafe_state, link::SerialLink& link, core::TimePoint now);
  /// Once per tick, after the supervisor: gives control back that has been ours for 0.8 s while the failsafe stayed in
  /// kSilent, as when no pose arrives: control that is not used blocks the pilot's sticks.
  void release_unused(safety::FailsafeState failsafe_state, link::SerialLink& link, core::TimePoint now);
  /// The law flies: the order is served.
  void serve(core::TimePoint now) { until_ = served_ = now; }
  /// When an order was last served.
  core::TimePoint served() const { return served_; }

  /// The orders that this tick acts upon: log::kOrder*.
  std::uint32_t acting() const { return acting_; }
  /// @param in_reach of this tick; without it a valid engage order is not served.
  safety::OrderStatus status(bool in_reach, core::TimePoint now) const;
  bool takes_off() const;
  bool hovers_here() const {
    constexpr std::uint32_t kBoth = log::kOrderLands | log::kOrderEngage;
    return (acting_ & kBoth) == kBoth;
  }

 private:
  core::Duration timeout_;
  core::TimePoint served_{};
  core::TimePoint until_{};
  bool stands_ = false;  ///< an order to fly is valid, as of this tick
  core::TimePoint unused_since_{};
  std::uint32_t given_ = 0;   ///< since the last tick
  std::uint32_t acting_ = 0;  ///< in this tick
  std::uint8_t tasks_ = 0;    ///< requests so far: the sequence number of the last
};

}  // namespace m100::app
