// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "firmware/core/time.h"
#include "host_tests/sim/world/random.h"
#include "host_tests/sim/world/vehicle_port.h"
#include "protocol/dji/commands.h"
#include "protocol/dji/telemetry.h"

namespace m100::sim {

/// Standard deviations of the errors in the state that the autopilot reports.
struct N1SensorNoise {
  double attitude_rad = 0.0;
  double rate_rad_s = 0.0;
  double force_m_s2 = 0.0;
  double velocity_m_s = 0.0;
  // Errors of its own estimates: see N1Estimator.
  double force_offset_m_s2 = 0.0;
  double force_vibration_m_s2 = 0.0;
  double velocity_zero_share = 0.0;
  double height_drift_m = 0.0;
};

using N1Rates = std::array<protocol::Rate, protocol::kTelemetryItemCount>;

/// The default rates of DJI's assistant: most items 50 Hz, magnetometer off, status 10 Hz, battery and control 1 Hz
/// (protocol, 4.3).
inline constexpr N1Rates kAssistantRates{protocol::Rate::k50Hz, protocol::Rate::k50Hz, protocol::Rate::k50Hz,
                                         protocol::Rate::k50Hz, protocol::Rate::k50Hz, protocol::Rate::k50Hz,
                                         protocol::Rate::kOff,  protocol::Rate::k50Hz, protocol::Rate::k50Hz,
                                         protocol::Rate::k10Hz, protocol::Rate::k1Hz,  protocol::Rate::k1Hz};

/// Items that are due in the 100 Hz slot with this number. One package carries them all (protocol, 4.3).
std::uint16_t due_items(const N1Rates& rates, std::uint64_t slot);

/// The autopilot's own estimate of the aircraft's motion. Without GPS its horizontal velocity is the integral of its
/// accelerometer, which is reset to zero, stays there, and starts again. Its height comes from a barometer, which
/// drifts and is reset. Its accelerometer has an offset that differs between flights, and the vibration of the rotors.
/// As in the measured logs, intervals at zero and intervals of drift last about a second each, with exponential length,
/// and the drift ends in one sample.
class N1Estimator {
 public:
  N1Estimator(const N1SensorNoise& noise, std::uint64_t seed);
  /// @param passed time since the previous call. @returns the estimated state.
  VehicleState update(const VehicleState& truth, core::Duration passed);

 private:
  void estimate_velocity(const VehicleState& truth, double step_s, VehicleState& estimated);
  void estimate_height(const VehicleState& truth, double step_s, VehicleState& estimated);
  void add_accelerometer_errors(VehicleState& estimated);

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

/// The state as the autopilot reports it: NED and FRD, acceleration raw in the body frame in g (so (0, 0, -1) at rest,
/// as the ETH group observed), position around an arbitrary home, otherwise DJI's units.
/// @param ticks of the 400 Hz clock.
protocol::Telemetry report(const VehicleState& state, std::uint32_t ticks, const N1SensorNoise& noise, Random& random);

}  // namespace m100::sim
