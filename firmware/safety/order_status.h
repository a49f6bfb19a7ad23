// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace m100::safety {

/// The operator's orders in one tick.
struct OrderStatus {
  bool engages = false;     ///< a valid order to fly (FlightConfig::order_timeout), and the aircraft is in reach
  bool releases = false;    ///< the order to give control back, in the tick in which it takes effect
  bool task_flies = false;  ///< the autopilot takes off or lands by its own task
};

}  // namespace m100::safety
