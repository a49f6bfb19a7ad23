// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/maths.h"

namespace m100::core {

/// The turn of an angle that several ask for in one tick: sine and cosine are taken once, until the angle is another.
/// The same numbers as turn_of(); a zero counts as the zero of the other sign.
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

/// Those of roll and pitch.
template <typename T>
struct TiltTurns {
  StandingTurn<T> roll;
  StandingTurn<T> pitch;
};

}  // namespace m100::core
