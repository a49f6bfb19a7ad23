// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "firmware/core/time.h"
#include "host_tests/sim/random.h"
#include "host_tests/sim/vehicle_port.h"
#include "protocol/commands.h"
#include "protocol/telemetry.h"

namespace m100::sim {

/// Standard deviations of what the autopilot reports about the true state.
struct N1SensorNoise {
  double attitude_rad = 0.0;
  double rate_rad_s = 0.0;
  double force_m_s2 = 0.0;
  double velocity_m_s = 0.0;
};

using N1Rates = std::array<protocol::Rate, protocol::kTelemetryItemCount>;

/// What DJI's assistant shows before anybody changed it: most items 50 Hz, magnetometer off, status 10 Hz, battery and
/// control 1 Hz (protocol, 4.3).
inline constexpr N1Rates kAssistantRates{protocol::Rate::k50Hz, protocol::Rate::k50Hz, protocol::Rate::k50Hz,
                                         protocol::Rate::k50Hz, protocol::Rate::k50Hz, protocol::Rate::k50Hz,
                                         protocol::Rate::kOff,  protocol::Rate::k50Hz, protocol::Rate::k50Hz,
                                         protocol::Rate::k10Hz, protocol::Rate::k1Hz,  protocol::Rate::k1Hz};

/// Items that are due in the 100 Hz slot with this number. One package carries them all (protocol, 4.3).
std::uint16_t due_items(const N1Rates& rates, std::uint64_t slot);

/// The true state as the autopilot reports it: NED and FRD, acceleration raw in the body frame in g (so (0, 0, -1) at
/// rest, as the ETH group saw it), position around a made-up home, DJI's numbers otherwise.
/// @param ticks of the 400 Hz clock.
protocol::Telemetry report(const VehicleState& state, std::uint32_t ticks, const N1SensorNoise& noise, Random& random);

}  // namespace m100::sim
