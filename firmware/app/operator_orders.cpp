// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/operator_orders.h"

#include "firmware/log/records.h"

namespace m100::app {
namespace {

/// Shorter than the second after which the autopilot ends Virtual RC by itself.
constexpr core::Duration kUnusedControl = std::chrono::milliseconds(800);

}  // namespace

core::Status OperatorOrders::begin_task(protocol::Task task, link::SerialLink& link, core::TimePoint now) {
  given_ |= log::kOrderTask;
  return link.request({.sequence = ++tasks_, .task = task}, now);
}

void OperatorOrders::update(bool in_reach, safety::FailsafeState failsafe_state, link::SerialLink& link,
                            core::TimePoint now) {
  acting_ = given_;
  given_ = 0;
  const bool is_silent = failsafe_state == safety::FailsafeState::kSilent;
  if ((acting_ & log::kOrderEngage) != 0 && !safety::passes_law(failsafe_state) && in_reach) {
    link.request_control(now);
    until_ = now + timeout_;
  }
  if (stands_ && now >= until_ && is_silent) {
    link.release(now);  // the order has expired: a request that still waits must not be served later
  }
  if ((acting_ & log::kOrderRelease) != 0) {
    until_ = now;
    if (is_silent || (acting_ & (log::kOrderTakesOff | log::kOrderLands)) != 0) {
      link.release(now);  // nothing flies by our commands: requested or granted control goes back at once
    }
  }
  stands_ = now < until_;
}

void OperatorOrders::release_unused(safety::FailsafeState failsafe_state, link::SerialLink& link, core::TimePoint now) {
  const bool unused = link.authority().in_control && failsafe_state == safety::FailsafeState::kSilent;
  unused_since_ = unused ? unused_since_ : now;
  if (unused && now - unused_since_ > kUnusedControl) {
    link.release(now);
  }
}

safety::OrderStatus OperatorOrders::status(bool in_reach, core::TimePoint now) const {
  return {.engages = now < until_ && in_reach,
          .releases = (acting_ & log::kOrderRelease) != 0,
          .task_flies = (acting_ & (log::kOrderTakesOff | log::kOrderLands)) != 0};
}

bool OperatorOrders::takes_off() const { return (acting_ & log::kOrderTakesOff) != 0; }

}  // namespace m100::app
