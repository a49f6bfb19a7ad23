// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace m100::mpc {

inline constexpr std::size_t kHorizon = 20;       ///< N
inline constexpr std::size_t kMaxStates = 4;      ///< position, velocity, tilt [, tilt rate]
inline constexpr double kPredictionStep_s = 0.1;  ///< between two inputs of the sequence
inline constexpr std::uint16_t kMaxChanges = 64;  ///< of the active set in one try

/// One axis' quadratic program (paper, Eq. 2, one axis at hover): all data that changes from tick to tick.
///
/// All data refer to the moment at which the input computed now begins to act: state and reference are one transport
/// delay ahead of the tick (see delay_predictor.h). Tilts and inputs are slopes (tangents of an angle), so that the
/// limits and gravity's part are exact at any tilt.
template <typename T>
struct Problem {
  std::array<T, kMaxStates> state{};  ///< m, m/s, slope, slope/s; the last unused for a first-order model
  T previous_input_slope{0};
  T disturbance_m_s2{0};
  T input_offset_slope{0};                     ///< the vehicle responds to u + offset (trim); input_ref_slope is for u
  std::array<T, kHorizon> position_ref_m{};    ///< r_1..r_20
  std::array<T, kHorizon> velocity_ref_m_s{};  ///< r_1..r_20
  std::array<T, kHorizon> tilt_ref_slope{};    ///< r_1..r_20
  std::array<T, kHorizon> input_ref_slope{};   ///< s_0..s_19
  bool constant_targets = false;               ///< tilt and input target: only entry 0 of each is read
  bool constant_reference = false;  ///< positions and targets constant, velocity 0: the set-point law can be used
};

/// Which law gave the solution.
enum class Path : std::uint8_t {
  kSetpoint,   ///< the explicit law: exact, first input only
  kTable,      ///< no limit binds: exact
  kActiveSet,  ///< limits bind: exact, certified
  kClipped,    ///< degraded: unconstrained sequence, clipped to the limits
};

template <typename T>
struct Solution {
  std::array<T, kHorizon> input_slope{};  ///< u_0..u_19; only u_0 when path is kSetpoint
  Path path = Path::kTable;
  std::uint16_t changes = 0;  ///< of the active set
  T kkt_residual{0};          ///< of kActiveSet: largest violation of the optimality conditions, cost per slope
};

}  // namespace m100::mpc
