// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "firmware/core/time.h"
#include "host_tests/sim/world/random.h"
#include "host_tests/sim/world/vehicle_port.h"
#include "protocol/commands.h"
#include "protocol/telemetry.h"

namespace m100::sim {

/// Standard deviations of what the autopilot reports about the true state.
struct N1SensorNoise {
  double attitude_rad = 0.0;
  double rate_rad_s = 0.0;
  double force_m_s2 = 0.0;
  double velocity_m_s = 0.0;
  // What its own estimates are like: see N1Senses.
  double force_offset_m_s2 = 0.0;
  double force_vibration_m_s2 = 0.0;
  double velocity_zero_share = 0.0;
  double height_drift_m = 0.0;
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

/// What the autopilot believes of the aircraft's motion. It has no eyes: without GPS its horizontal velocity is its
/// accelerometer's integral, which it sets to zero, leaves there, and takes up again; its height is a barometer's,
/// which drifts and is set anew; its accelerometer has an offset from flight to flight and feels the rotors. As in the
/// measured logs: stretches at zero and stretches that drift last about a second each, their length exponential, and
/// the drift ends in one sample.
class N1Senses {
 public:
  N1Senses(const N1SensorNoise& noise, std::uint64_t seed);
  /// @param passed since the call before. @returns the state as it is believed.
  VehicleState sense(const VehicleState& truth, core::Duration passed);

 private:
  void sense_velocity(const VehicleState& truth, double step_s, VehicleState& believed);
  void sense_height(const VehicleState& truth, double step_s, VehicleState& believed);
  void feel(VehicleState& believed);

  N1SensorNoise noise_;
  Random random_;
  core::Vector<double, 3> offset_b_m_s2_;
  bool drifting_ = false;
  double next_switch_s_ = 0.0;
  core::Vector<double, 3> from_w_m_s_ = core::Vector<double, 3>::Zero();  ///< true velocity where the drift began
  core::Vector<double, 3> drift_w_m_s_ = core::Vector<double, 3>::Zero();
  ColouredNoise barometer_;
  double height_from_m_ = 0.0;
  bool was_in_air_ = false;
};

/// The true state as the autopilot reports it: NED and FRD, acceleration raw in the body frame in g (so (0, 0, -1) at
/// rest, as the ETH group saw it), position around a made-up home, DJI's numbers otherwise.
/// @param ticks of the 400 Hz clock.
protocol::Telemetry report(const VehicleState& state, std::uint32_t ticks, const N1SensorNoise& noise, Random& random);

}  // namespace m100::sim
