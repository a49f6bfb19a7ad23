// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <functional>
#include <optional>

#include "firmware/core/pose.h"
#include "firmware/core/time.h"
#include "host_tests/sim/world/plant.h"
#include "host_tests/sim/world/random.h"
#include "host_tests/sim/world/vehicle_port.h"

namespace m100::sim {

/// One pose of the motion capture, as it arrives.
struct PoseSample {
  std::uint32_t sequence = 0;  ///< counted by the source at capture, so that a lost pose leaves a gap
  core::TimePoint captured{};  ///< true time of capture, on our clock
  core::SenderTime stamp{};    ///< time stamp of the source, on its clock
  core::Vector<double, 3> position_w_m = core::Vector<double, 3>::Zero();
  double yaw_rad = 0.0;
};

/// Faults of a motion capture.
struct PoseFaults {
  bool silent = false;  ///< no pose arrives
  bool frozen = false;  ///< the same pose for ever, with a running time stamp
  bool not_finite = false;
  core::Vector<double, 3> jump_m = core::Vector<double, 3>::Zero();
  double turn_rad = 0.0;  ///< of the whole frame about z
  core::Duration extra_delay{0};
  core::Duration jitter{0};  ///< extra delay between 0 and this, drawn for each pose
  /// Changes a sample after its noise was added; empty: no change.
  std::function<void(PoseSample& sample)> fault{};
};

/// A pose source with its own clock: noise, age, bursts and dropouts as the plant states, faults as a test sets them.
///
/// It captures at its own times. Each pose arrives `latency` and its own drawn jitter later, or at the end of a pause
/// of the network, so poses may overtake each other. The caller calls step() at next_event(), or as often as it can,
/// and receives the poses in the order of arrival.
class PoseSource {
 public:
  PoseSource(const PoseNumbers& numbers, std::uint64_t seed);

  /// The time of the next capture or arrival. Calls of step() between two such times change nothing.
  core::TimePoint next_event() const;

  /// Makes the captures that are due, and returns the next arrived pose.
  /// @param truth the aircraft as it was at `truth_at`, which may lie a few milliseconds off `now`: a capture between
  ///   is taken from it with constant velocity (4 m/s^2 over 2.5 ms: 0.01 mm).
  /// @returns a pose that has arrived, if one has; call again until there is none.
  std::optional<PoseSample> step(core::TimePoint now, const VehicleState& truth, double yaw_rad,
                                 core::TimePoint truth_at);

  /// The time on the source's clock: microseconds of Unix time, fast by its drift.
  core::SenderTime own_time(core::TimePoint now) const;
  /// Whether it answers requests for its time.
  bool tells_time() const { return numbers_.reported_age != ReportedAge::kNone; }
  const PoseNumbers& numbers() const { return numbers_; }

  void set_faults(const PoseFaults& faults) { faults_ = faults; }
  const PoseFaults& faults() const { return faults_; }

 private:
  struct Travelling {
    core::TimePoint arrival;
    PoseSample sample;
  };
  core::TimePoint capture_time(std::uint64_t number) const;
  void capture(core::TimePoint at, const VehicleState& truth, double yaw_rad, core::TimePoint truth_at);
  void spoil(PoseSample& sample);
  core::TimePoint arrival_of(core::TimePoint captured, double jitter);

  PoseNumbers numbers_;
  Random random_;
  Random network_;
  PoseFaults faults_;
  double phase_s_ = 0.0;
  std::uint64_t captures_ = 0;
  core::TimePoint next_{};
  core::TimePoint back_{};        ///< end of the dropout
  core::TimePoint held_until_{};  ///< end of the network's pause
  std::deque<Travelling> air_;    ///< by arrival, then by capture
  std::optional<PoseSample> frozen_;
};

}  // namespace m100::sim
