// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/app/sensor_adapter.h"
#include "firmware/core/fence.h"
#include "firmware/core/maths.h"
#include "firmware/ctl/excitation.h"
#include "firmware/est/consistency/velocity_consistency.h"
#include "firmware/link/pose/pose_link.h"
#include "firmware/link/serial_link.h"
#include "firmware/mpc/law.h"
#include "firmware/safety/limits.h"

namespace m100::app {

/// Configuration of a flight apart from the vehicle: chosen at run time, before the first tick.
struct FlightConfig {
  link::LinkConfig link;
  safety::Limits limits;
  safety::Envelope envelope;
  SensorLimits sensor_limits;
  core::Fence fence;
  /// An order to fly has no effect farther than this from the course's beginning [m]: the law would fly there at once.
  double reach_m = 1e9;
  mpc::Law law = mpc::Law::kMpc;  ///< of the horizontal axes
  bool plans_setpoints = true;    ///< set points are flown as motions of ctl::SetpointPlanner, not as jumps
  /// The law of the paper's authors (model::paper_configuration, model/PAPER.md): it flies [design] on the measured
  /// tilt and an integral (ctl::PaperState), the observer the identified axes; vrc::StickRule::kAsThePaper; no planner,
  /// no learned trims.
  bool paper_law = false;
  /// True: the horizontal quadratic programs are solved only in ticks that can send a command, at 25 Hz one in four.
  /// Between them the last command is held. For slow processors.
  bool solves_when_due = false;
  bool responds_to_limit_cycles =
      true;                           ///< false: no reaction to a limit cycle, and no report (tests of the law alone)
  est::CheckSet disabled_checks = 0;  ///< checks of pose against autopilot that the operator has switched off by name
  ctl::ExcitationPlan excitation{};   ///< empty: none. Virtual RC only; what it views must outlive the flight
  /// Assumed age of the attitude in a telemetry package when a tick reads it; the autopilot does not state it. It is
  /// the sum of three estimates, about a tick: half a period of 100 Hz inside the autopilot, 1.5 ms on the wire at
  /// 921600 baud (protocol, section 10), and half a tick until it is read. At 230400 baud the sum is 16 ms.
  core::Duration attitude_age = std::chrono::milliseconds(10);
  std::uint32_t pose_baud = 115200;  ///< of the poses' UART
  link::SenderChoice pose_from{};    ///< whose poses are used
  link::LeverArm pose_offset_b_m{};
  double pose_sigma_m = 0.0;  ///< link::PoseProperties::sigma_m
  /// How long an order to fly stays valid if it is not served: start-up and the requests for control take time.
  core::Duration order_timeout = std::chrono::seconds(20);
};

inline constexpr FlightConfig kDefaultFlight{};
static_assert(kDefaultFlight.limits.pose_fresh == std::chrono::milliseconds(60), "promise R3");
static_assert(kDefaultFlight.limits.pose_fresh < kDefaultFlight.limits.coast);
static_assert(kDefaultFlight.limits.telemetry_stale < kDefaultFlight.limits.telemetry_dead);
static_assert(kDefaultFlight.envelope.tilt_rad < 35.0 * core::kDegree_rad, "promise R12: never above 35 degrees");
static_assert(kDefaultFlight.attitude_age < 2 * core::kTickPeriod);

}  // namespace m100::app
