// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "host_tests/sim/world/axis_motion.h"
#include "host_tests/sim/world/carried_load.h"
#include "host_tests/sim/world/plant.h"
#include "host_tests/sim/world/random.h"
#include "host_tests/sim/world/vehicle_port.h"
#include "host_tests/sim/world/wind.h"

namespace m100::sim {

/// The aircraft near hover, in three dimensions. World NWU, body FLU, SI.
///
///   roll, pitch       follow their sticks (AxisMotion), plus coloured motion caused by the air
///   yaw' = yaw rate   follows its stick; a held heading wanders as a damped oscillator driven by noise (Wander)
///   z'   = climb      follows its stick; the autopilot holds height by itself
///   horizontally      v' = T/m b3 + air(v - wind) [+ pull of a slung load], where the autopilot compensates thrust for
///                     tilt (paper, III-B.2): T/m = (g + z'') / (cos roll cos pitch)
///   slung load        a pendulum, small angles, modelled as an additional horizontal acceleration
/// The attitude loops weaken with payload (bandwidth by the square root of the mass ratio) and with the battery.
/// The ground is at z = 0; the aircraft can stand on it, and the fastest touchdown is stored.
class Vehicle final : public VehiclePort {
 public:
  Vehicle(const Plant& plant, std::uint64_t seed, const core::Vector<double, 3>& position_w_m, double yaw_rad = 0.0);

  void command(const VehicleInput& input) override;
  void set_motors(bool on) override { state_.motors_on = on; }
  void advance(core::Duration step) override;
  const VehicleState& state() const override { return state_; }

  /// Roll, pitch, yaw in rad, from which state().rotation_wb was computed.
  core::Euler<double> attitude() const override { return attitude_; }
  /// Fastest downward touch of the ground so far, m/s; 0: never touched.
  double touchdown_speed_m_s() const { return hardest_touch_m_s_; }

  /// Changes the world in flight (fault tests): mass in addition to the plant's payload, and a factor on the bandwidth.
  void add_payload(double mass_kg) { plant_.payload.mass_kg += mass_kg; }
  void slow_actuators(double factor) { actuators_ = factor; }

 private:
  core::Vector<double, 3> integrate(double step_s);  ///< @returns the acceleration
  void change_when_due();
  double carried_kg() const { return time_s_ >= plant_.payload.picked_up_at_s ? plant_.payload.mass_kg : 0.0; }
  /// Bandwidth of the attitude loops, relative to that with a fresh battery and no payload.
  double authority() const;
  /// Effect of payload and ground on the climb speed that the autopilot holds.
  double climb_offset_m_s(double step_s);
  core::Vector<double, 3> aerodynamic_acceleration(const core::Vector<double, 3>& wind) const;
  void publish(const core::Vector<double, 3>& acceleration);

  /// What the air does to the heading.
  struct HeadingAir {
    Wander held;         ///< of a heading that the autopilot holds: it wanders and returns
    Random random;       ///< a stream of its own, so that worlds without a turn keep their flights
    ColouredNoise turn;  ///< Air::turn_disturbance_rad_s
  };

  Plant plant_;
  Wind wind_;
  Random random_;
  AxisMotion roll_;
  AxisMotion pitch_;
  AxisMotion yaw_rate_;
  AxisMotion climb_;
  Wander roll_wander_;
  Wander pitch_wander_;
  HeadingAir heading_air_;
  Wander climb_wander_;
  double yaw_rad_ = 0.0;
  CarriedLoad load_;
  core::Euler<double> attitude_;
  double lift_m_s2_ = model::kGravity_m_s2;
  double actuators_ = 1.0;
  double time_s_ = 0.0;
  bool has_changed_ = false;
  double hardest_touch_m_s_ = 0.0;
  VehicleState state_;
};

}  // namespace m100::sim
