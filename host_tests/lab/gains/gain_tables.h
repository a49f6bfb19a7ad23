// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <type_traits>

#include "firmware/core/sha256.h"
#include "firmware/model/vehicle.h"
#include "firmware/mpc/gain_table.h"
#include "host_tests/lab/gains/axis_model.h"

namespace m100::lab::gains {

/// H and the matrices of f. The cost over the 20 inputs U is J = 1/2 U'HU + f'U, with the references r of the states
/// and u_ref of the inputs: f = S'Qb (Tx x0 + Td d - r) - R u_ref - Rd u_prev e_0.
struct Condensed {
  Matrix s;         ///< 20 n x 20, inputs to states x_1..x_20
  Matrix tx;        ///< 20 n x n
  Vector td;        ///< 20 n
  Matrix weighted;  ///< S'Qb, 20 x 20 n
  Matrix h;         ///< 20 x 20
};
/// Eliminates the states. With n states in the problem, a and p are n x n; b, bd and q have n entries.
Condensed condense(const AxisQp& problem);

/// The table of one quadratic program, without delay and set-point law. Preconditions: weights not negative, r > 0,
/// u_min < u_max; the first state is the position, and no other state depends on it. Throws std::domain_error unless
/// there are 3 or 4 states.
mpc::GainTable<double> make_gain_table(const AxisQp& problem);

/// The model for predicting through the axis' transport delay, 0 to 0.3 s. Throws as continuous_axis() does.
mpc::DelayModel<double> make_delay_model(const model::Vehicle& vehicle, Axis axis);

/// The table of one axis with its delay model, without the set-point law, for the vehicle's design where it has one.
/// Throws std::domain_error if the model cannot be controlled.
mpc::GainTable<double> make_axis_table(const model::Vehicle& identified, Axis axis);

/// The tables of both axes, as make_axis_table() makes them. `digest` is that of the vehicle file.
mpc::GainTables<double> make_gain_tables(const model::Vehicle& identified, const core::Sha256Digest& digest = {});

/// The table in float, as in the firmware: every double rounded. The set-point law is omitted.
mpc::GainTable<float> to_float(const mpc::GainTable<double>& table);
inline mpc::GainTables<float> to_float(const mpc::GainTables<double>& tables) {
  return {.x = to_float(tables.x), .y = to_float(tables.y)};
}
template <typename T>
mpc::GainTable<T> table_in(const mpc::GainTable<double>& table) {
  if constexpr (std::is_same_v<T, double>) {
    return table;
  } else {
    return to_float(table);
  }
}

}  // namespace m100::lab::gains
