// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/time.h"
#include "firmware/ctl/law/geofence_status.h"
#include "firmware/ctl/monitor/control_authority_status.h"
#include "firmware/ctl/monitor/limit_cycle_status.h"
#include "firmware/est/consistency_status.h"
#include "firmware/est/estimate_status.h"
#include "firmware/safety/flight_state.h"
#include "firmware/safety/limits.h"
#include "firmware/safety/link_status.h"
#include "firmware/safety/order_status.h"
#include "firmware/sysid/model_status.h"

namespace m100::safety {

/// Inputs of the supervisor in one tick, each filled by the part that measures it. The supervisor turns them into
/// conditions by its Limits.
struct Observation {
  core::TimePoint now{};
  est::EstimateStatus estimate{};
  MeasuredLatency pose_latency{};  ///< as measured in flight; decides what counts as fresh
  est::ConsistencyStatus consistency{};
  LinkStatus link{};
  OrderStatus orders{};
  ctl::GeofenceStatus fence{};
  ctl::ControlAuthorityStatus wind{};
  ctl::LimitCycleStatus limit_cycle{};
  FlightState flight{};        ///< whether the aircraft still flies
  sysid::ModelStatus model{};  ///< as of the last tick: the sticks that it is compared with leave after the supervisor
};

}  // namespace m100::safety
