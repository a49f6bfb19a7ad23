// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "hal/mock/manual_clock.h"
#include "hal/mock/uart_pair.h"
#include "host_tests/sim/autopilot/n1_autopilot.h"
#include "host_tests/sim/ports/pose_sender.h"
#include "host_tests/sim/world/plant.h"
#include "host_tests/sim/world/vehicle.h"

namespace m100::sim {

struct WorldOptions {
  std::uint64_t seed = 1;
  core::Vector<double, 3> position_w_m{0.0, 0.0, 1.5};
  double yaw_rad = 0.0;
  N1Config autopilot{};  ///< baud, seed and noise are taken from the plant and the seed
  /// The aircraft to fly instead of the identified response: it outlives the world. Null: the identified response.
  VehiclePort* body = nullptr;
};

/// The plant's sensor errors as parameters of the autopilot.
N1SensorNoise noise_of(const Sensors& sensors);

/// Everything outside the companion computer: aircraft, wind, the autopilot on one cable, motion capture on the other,
/// and their common clock. The program under test has the two near ends.
///
/// A pilot holds the aircraft at the trim of its sticks until the program takes over, as before the paper's
/// experiments. The same plant, options and calls give the same flight, bit for bit.
class World {
 public:
  World(const Plant& plant, const WorldOptions& options);
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  hal::Uart& autopilot_uart() { return autopilot_line_.a(); }
  hal::Uart& pose_uart() { return pose_line_.a(); }
  core::TimePoint now() { return clock_.now(); }

  /// Advances time in steps of the autopilot's 400 Hz, and to each capture and arrival of a pose.
  void advance(core::Duration step);

  /// Starts this lie in its channel.
  void fault(const SensorFault& fault, double size);

  /// The identified response; it stands still where a body flies.
  Vehicle& vehicle() { return vehicle_; }
  /// The aircraft that flies.
  const VehiclePort& aircraft() const { return aircraft_; }
  N1Autopilot& autopilot() { return autopilot_; }
  PoseSource& pose_source() { return pose_sender_.source(); }
  /// Time of capture of the newest pose that has passed the line by now.
  core::TimePoint newest_pose_captured() { return pose_sender_.newest_captured(clock_.now()); }
  hal::UartPair& autopilot_line() { return autopilot_line_; }
  hal::UartPair& pose_line() { return pose_line_; }
  hal::ManualClock& clock() { return clock_; }

 private:
  hal::ManualClock clock_;
  hal::UartPair autopilot_line_;
  hal::UartPair pose_line_;
  Vehicle vehicle_;
  VehiclePort& aircraft_;
  N1Autopilot autopilot_;
  PoseSender pose_sender_;
};

}  // namespace m100::sim
