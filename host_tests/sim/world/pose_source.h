// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <functional>
#include <limits>
#include <optional>

#include "firmware/core/pose.h"
#include "firmware/core/time.h"
#include "host_tests/sim/world/plant.h"
#include "host_tests/sim/world/random.h"
#include "host_tests/sim/world/vehicle_port.h"

namespace m100::sim {

/// One pose of the motion capture, as it arrives.
struct PoseSample {
  std::uint32_t sequence = 0;  ///< counted by the source at capture, so that a pose that was lost leaves a hole
  core::TimePoint captured{};  ///< the truth, on our clock
  core::SenderTime stamp{};    ///< what the source says, on its clock
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
  /// What else becomes of a sample, after its noise; empty: nothing.
  std::function<void(PoseSample& sample)> lie{};
};

/// A source of pose on a clock of its own: noise, age, bunches and dropouts as the plant says, faults as a test says.
///
/// It captures at its own times, which need not be ours, and each pose travels by itself: it arrives `latency` later,
/// plus its own share of the jitter, or at the end of a pause of the network. So poses may overtake each other. Who
/// flies it visits it at next_event(), or as often as he can, and gets what has arrived in the order of arrival.
class PoseSource {
 public:
  PoseSource(const PoseNumbers& numbers, std::uint64_t seed);

  /// When something happens next: a capture or an arrival. Visits between two such times change nothing.
  core::TimePoint next_event() const;

  /// Captures what is due, and hands over what has travelled long enough.
  /// @param truth the aircraft as it was at `truth_at`, which may lie a few milliseconds off `now`: a capture between
  ///   is taken from it with constant velocity (4 m/s^2 over 2.5 ms: 0.01 mm).
  /// @returns a pose that has arrived, if one has; call again until there is none.
  std::optional<PoseSample> step(core::TimePoint now, const VehicleState& truth, double yaw_rad,
                                 core::TimePoint truth_at);

  /// What the source's clock shows: microseconds of Unix time, fast by its drift.
  core::SenderTime own_time(core::TimePoint now) const;
  /// Whether it says so when it is asked.
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
