// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/maths.h"

namespace m100::core {

/// Caches the sine and cosine of an angle that several callers use in one tick; recomputes them only for a different
/// angle. Gives the numbers of sin_cos_of(); zeros of either sign count as equal.
template <typename T>
class CachedSinCos {
 public:
  const SinCos<T>& of(T angle_rad) {
    if (!(angle_rad == angle_rad_)) {
      angle_rad_ = angle_rad;
      turn_ = sin_cos_of(angle_rad);
    }
    return turn_;
  }

 private:
  T angle_rad_{0};
  SinCos<T> turn_;
};

template <typename T>
struct RollPitchSinCos {
  CachedSinCos<T> roll;
  CachedSinCos<T> pitch;
};

}  // namespace m100::core
