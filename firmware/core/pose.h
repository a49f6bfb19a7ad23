// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/eigen.h"
#include "firmware/core/time.h"

namespace m100::core {

/// The clock of whoever measures the pose: microseconds since it began, which nobody here knows. A type of its own, so
/// that its times cannot be mixed with ours.
struct SenderClock {
  using rep = std::int64_t;
  using period = std::micro;
  using duration = std::chrono::duration<rep, period>;
  using time_point = std::chrono::time_point<SenderClock>;
  static constexpr bool is_steady = true;
};
using SenderTime = SenderClock::time_point;

/// What both sides found by asking each other for the time (TIMESYNC). Who only listens has none.
struct ClockOffset {
  bool known = false;
  Duration to_ours{0};  ///< our time is theirs plus this, if the way there takes as long as the way back
  Duration bound{0};    ///< how wrong it may be where it does not: half of what there and back took
};

/// A pose of the aircraft, one type from the port to the observer. World NWU, body FLU. T is float or double.
template <typename T>
struct Pose {
  bool is_new = false;         ///< came in this tick
  std::uint32_t sequence = 0;  ///< of the sender; one more per pose
  SenderTime captured{};       ///< on the sender's clock
  /// What turns the sender's clock into ours: our time of a capture is captured + to_ours. From the link it says that
  /// the pose is as old as its arrival; est::PoseTiming finds out.
  Duration to_ours{0};
  ClockOffset offset;   ///< what is known of the two clocks beside that
  TimePoint arrived{};  ///< on our clock
  Vector<T, 3> position_w_m = Vector<T, 3>::Zero();
  T yaw_rad{0};
  /// Uncertainty of the time of capture: the observer gives it as much room as the aircraft flies in that time.
  T time_sigma_s{0};
  /// Variance that the sender claims, along each axis of the world; 0: none told. The observer takes the larger of this
  /// and the vehicle file's.
  Vector<T, 3> position_variance_m2 = Vector<T, 3>::Zero();

  constexpr TimePoint captured_at() const { return TimePoint(captured.time_since_epoch() + to_ours); }
  /// From capture to `now`, both on our clock.
  constexpr Duration age(TimePoint now) const { return now - captured_at(); }
  /// Says when it was captured on our clock, where the sender has none or shares ours.
  constexpr void set_captured_at(TimePoint at) {
    captured = SenderTime(at.time_since_epoch());
    to_ours = Duration{0};
  }

  template <typename Other>
  Pose<Other> cast() const {
    return {.is_new = is_new,
            .sequence = sequence,
            .captured = captured,
            .to_ours = to_ours,
            .offset = offset,
            .arrived = arrived,
            .position_w_m = position_w_m.template cast<Other>(),
            .yaw_rad = static_cast<Other>(yaw_rad),
            .time_sigma_s = static_cast<Other>(time_sigma_s),
            .position_variance_m2 = position_variance_m2.template cast<Other>()};
  }
};

}  // namespace m100::core
