// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace m100::lab::logs {

/// w, x, y, z; rotates a body vector into a world vector.
using Quaternion = std::array<double, 4>;

/// Roll, pitch, yaw [rad], z-y-x: R = Rz(yaw) Ry(pitch) Rx(roll). Precondition: not zero; its length does not matter.
std::array<double, 3> euler_zyx(const Quaternion& q);

/// Makes four series of parts a continuous series of unit quaternions: q and -q are the same rotation, and a log may
/// switch between them at any sample. A quaternion whose length differs from 1 by a tenth or more becomes NaN.
/// @returns the number of those. Precondition: equal lengths.
std::size_t make_continuous(std::array<std::vector<double>*, 4> parts);

}  // namespace m100::lab::logs
