// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/maths.h"

namespace m100::core {

/// Caches the sine and cosine of an angle that several callers use in one tick; recomputes them only for a different
/// angle. The same numbers as turn_of(); zeros of either sign count as equal.
template <typename T>
class StandingTurn {
 public:
  const Turn<T>& of(T angle_rad) {
    if (!(angle_rad == angle_rad_)) {
      angle_rad_ = angle_rad;
      turn_ = turn_of(angle_rad);
    }
    return turn_;
  }

 private:
  T angle_rad_{0};
  Turn<T> turn_;
};

/// The cached turns of roll and pitch.
template <typename T>
struct TiltTurns {
  StandingTurn<T> roll;
  StandingTurn<T> pitch;
};

}  // namespace m100::core
