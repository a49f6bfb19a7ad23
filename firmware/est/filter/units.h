// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace m100::est {

/// The filter counts time in units of 0.64 s, so that one tick of 10 ms is 2^-6 and every coefficient of pure
/// integration (T, T^2/2) is a power of two, exact in fixed point. Lengths are in metres, angles in radians.
inline constexpr double kTimeUnit_s = 0.64;
inline constexpr int kTickExponent = -6;
inline constexpr double kTick_s = 0.01;
inline constexpr double kVelocityUnit_m_s = 1.0 / kTimeUnit_s;                       ///< one metre per unit
inline constexpr double kAccelerationUnit_m_s2 = 1.0 / (kTimeUnit_s * kTimeUnit_s);  ///< one metre per unit squared
inline constexpr double kRateUnit_rad_s = 1.0 / kTimeUnit_s;

}  // namespace m100::est
