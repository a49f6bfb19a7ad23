// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/eigen.h"
#include "firmware/core/time.h"

namespace m100::core {

/// The clock of the pose's sender: microseconds since a start that is unknown here. A type of its own, so that its
/// times cannot be mixed with ours.
struct SenderClock {
  using rep = std::int64_t;
  using period = std::micro;
  using duration = std::chrono::duration<rep, period>;
  using time_point = std::chrono::time_point<SenderClock>;
  static constexpr bool is_steady = true;
};
using SenderTime = SenderClock::time_point;

/// Result of a clock comparison between both sides (TIMESYNC); without one the offset is not known.
struct ClockOffset {
  bool known = false;
  Duration to_ours{0};  ///< our time is theirs plus this, if both directions take equally long
  Duration bound{0};    ///< largest error if they do not: half of the round trip
};

/// A pose of the aircraft; the same type from the port to the observer. World NWU, body FLU. T is float or double.
template <typename T>
struct Pose {
  bool is_new = false;         ///< came in this tick
  std::uint32_t sequence = 0;  ///< counts the accepted poses, set by the link
  SenderTime captured{};       ///< on the sender's clock; on ours after set_captured_at()
  bool clock_was_set = false;  ///< the sender's, since the pose before: shown by the order of its stamps
  /// Converts the sender's clock to ours: our time of a capture is captured + to_ours. The link sets it as if the pose
  /// was captured when it arrived; est::PoseTiming corrects it.
  Duration to_ours{0};
  ClockOffset offset;   ///< the comparison of the two clocks, where there is one
  TimePoint arrived{};  ///< on our clock
  Vector<T, 3> position_w_m = Vector<T, 3>::Zero();
  T yaw_rad{0};
  /// Uncertainty of the time of capture; the observer allows for the distance that the aircraft flies in it.
  T time_sigma_s{0};
  /// Variance that the sender claims, along each axis of the world; 0: none claimed. The observer uses the larger of
  /// this and the vehicle file's.
  Vector<T, 3> position_variance_m2 = Vector<T, 3>::Zero();

  constexpr TimePoint captured_at() const { return TimePoint(captured.time_since_epoch() + to_ours); }
  /// From capture to `now`, both on our clock.
  constexpr Duration age(TimePoint now) const { return now - captured_at(); }
  /// Sets the time of capture on our clock; `captured` is on our clock from then on.
  constexpr void set_captured_at(TimePoint at) {
    captured = SenderTime(at.time_since_epoch());
    to_ours = Duration{0};
  }

  template <typename Other>
  Pose<Other> cast() const {
    return {.is_new = is_new,
            .sequence = sequence,
            .captured = captured,
            .clock_was_set = clock_was_set,
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
