// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/core/frames.h"

namespace m100::core {

/// The world's up direction in body axes; (0, 0, 1) when level. The quaternion turns body vectors into the world. The
/// result does not depend on the heading.
template <typename T>
Vector<T, 3> up_in_body(const Quaternion<T>& q) {
  return {T(2) * (q.x * q.z - q.w * q.y), T(2) * (q.y * q.z + q.w * q.x), T(1) - T(2) * (q.x * q.x + q.y * q.y)};
}

}  // namespace m100::core
