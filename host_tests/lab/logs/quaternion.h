// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace m100::lab::logs {

/// w, x, y, z; turns a body vector into a world vector.
using Quaternion = std::array<double, 4>;

/// Roll, pitch, yaw [rad], z-y-x: R = Rz(yaw) Ry(pitch) Rx(roll). Precondition: not zero; its length does not matter.
std::array<double, 3> euler_zyx(const Quaternion& q);

/// Makes four series of parts one continuous series of unit quaternions: q and -q are the same rotation, and a log may
/// change between them at any sample. What is not of unit length within a tenth becomes NaN.
/// @returns how many were not. Precondition: equal lengths.
std::size_t make_continuous(std::array<std::vector<double>*, 4> parts);

}  // namespace m100::lab::logs
