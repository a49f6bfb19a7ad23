// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <limits>
#include <optional>

#include "firmware/core/time.h"
#include "host_tests/sim/plant.h"
#include "host_tests/sim/random.h"
#include "host_tests/sim/vehicle_port.h"

namespace m100::sim {

/// One pose of the motion capture, as it leaves the radio.
struct PoseSample {
  core::TimePoint captured{};
  core::Vector<double, 3> position_w_m = core::Vector<double, 3>::Zero();
  double yaw_rad = 0.0;
};

/// What may be wrong with a motion capture.
struct PoseFaults {
  bool silent = false;  ///< nothing comes
  bool frozen = false;  ///< the same pose for ever, with a running time stamp
  bool not_finite = false;
  core::Vector<double, 3> jump_m = core::Vector<double, 3>::Zero();
  double turn_rad = 0.0;  ///< of the whole frame about z
  core::Duration extra_delay{0};
  core::Duration jitter{0};  ///< extra delay between 0 and this, drawn for each pose
};

/// Motion capture at 100 Hz: noise, age and dropouts as the plant's sensors say, faults as a test says.
class PoseSource {
 public:
  static constexpr core::Duration kPeriod = std::chrono::milliseconds(10);

  PoseSource(const Sensors& sensors, std::uint64_t seed) : sensors_(sensors), random_(seed, "pose") {}

  /// Takes a picture when it is time, and hands over what has travelled long enough; call it at least every 10 ms.
  /// @returns a pose that arrives now, if one does; call again until there is none.
  std::optional<PoseSample> step(core::TimePoint now, const VehicleState& truth, double yaw_rad);

  void set_faults(const PoseFaults& faults) { faults_ = faults; }
  const PoseFaults& faults() const { return faults_; }

 private:
  void capture(core::TimePoint now, const VehicleState& truth, double yaw_rad);

  struct Travelling {
    core::TimePoint arrival;
    PoseSample sample;
  };
  Sensors sensors_;
  Random random_;
  PoseFaults faults_;
  core::TimePoint next_{};
  core::TimePoint back_{};  ///< end of the dropout
  std::deque<Travelling> air_;
  std::optional<PoseSample> frozen_;
};

}  // namespace m100::sim
