// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace m100::mpc {

inline constexpr std::size_t kHorizon = 20;   ///< N
inline constexpr std::size_t kMaxStates = 4;  ///< position, velocity, tilt [, tilt rate]

/// One axis' quadratic program (paper, Eq. 2, one axis at hover): everything that changes from tick to tick.
template <typename T>
struct Problem {
  std::array<T, kMaxStates> state{};  ///< m, m/s, rad, rad/s; the last unused for a first-order model
  T previous_input_rad{0};
  T disturbance_m_s2{0};
  std::array<T, kHorizon> position_ref_m{};    ///< r_1..r_20
  std::array<T, kHorizon> velocity_ref_m_s{};  ///< r_1..r_20
  std::array<T, kHorizon> tilt_ref_rad{};      ///< r_1..r_20
  std::array<T, kHorizon> input_ref_rad{};     ///< s_0..s_19
  bool constant_reference = false;             ///< all four the same over the horizon: the set-point law may serve
};

/// Which law answered.
enum class Path : std::uint8_t { kSetpoint, kTable, kActiveSet, kClipped };

template <typename T>
struct Solution {
  std::array<T, kHorizon> input_rad{};  ///< u_0..u_19; only u_0 when path is kSetpoint
  Path path = Path::kTable;
  std::uint16_t changes = 0;  ///< of the active set
  T kkt_residual{0};          ///< largest violation of the optimality conditions, cost per rad; 0 on kSetpoint, kTable
};

}  // namespace m100::mpc
