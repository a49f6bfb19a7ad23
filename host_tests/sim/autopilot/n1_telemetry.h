// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>

#include "firmware/core/time.h"
#include "host_tests/sim/autopilot/n1_behaviour.h"
#include "host_tests/sim/sensor_faults/sensor_fault_injector.h"
#include "host_tests/sim/world/random.h"
#include "host_tests/sim/world/vehicle_port.h"
#include "protocol/dji/commands.h"
#include "protocol/dji/frame.h"
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

/// Codes above 5; 200 and 400 Hz are for newer aircraft (protocol, 4.3). The decoder treats them as "keep the rate".
bool has_unknown_rate(const protocol::Message& message);

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

/// The telemetry stream: which items are due, the autopilot's estimate in them, and the faults that a script adds.
class N1Telemetry {
 public:
  N1Telemetry(const N1Behaviour::Telemetry& how, const N1Rates& rates, const N1SensorNoise& noise, std::uint64_t seed);

  void set_rates(const protocol::TelemetryFrequency& wanted);
  void set_silent_until(core::TimePoint until) { silent_until_ = until; }
  void restart() { slot_ = 0; }

  /// One slot of 10 ms. @returns the state's items, or nothing if no item is due.
  std::optional<protocol::Telemetry> next(const VehiclePort& vehicle, std::uint32_t ticks, core::TimePoint now);

  /// A function that changes each package before it is sent; empty: no change.
  void set_fault(std::function<void(protocol::Telemetry&)> fault) { fault_ = std::move(fault); }
  /// Replaces that function by a sensor fault.
  void start_fault(const SensorFault& fault, double size) {
    fault_injector_.emplace(fault, size);
    set_fault([this](protocol::Telemetry& telemetry) { fault_injector_->apply(telemetry); });
  }
  SensorFaultInjector* fault_injector() { return fault_injector_ ? &*fault_injector_ : nullptr; }
  void apply_fault(protocol::Telemetry& telemetry) const {
    if (fault_) {
      fault_(telemetry);
    }
  }

 private:
  const N1Behaviour::Telemetry& how_;
  N1Rates rates_;
  N1SensorNoise noise_;
  N1Estimator estimator_;
  Random random_;
  std::uint64_t slot_ = 0;
  core::TimePoint silent_until_{};
  std::function<void(protocol::Telemetry&)> fault_;
  std::optional<SensorFaultInjector> fault_injector_;
};

}  // namespace m100::sim
