// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/sha256.h"
#include "firmware/model/vehicle.h"
#include "firmware/mpc/gain_table.h"
#include "host_tests/tools/gains/axis_model.h"

namespace m100::tools::gains {

/// H and the maps that make f = H's linear part; see mpc/README.md of the benchmark: J = 1/2 U'HU + f'U,
/// f = S'Qb (Tx x0 + Td d - r) - R s - Rd u_prev e_0.
struct Condensed {
  Matrix s;   ///< 20 n x 20, inputs to states x_1..x_20
  Matrix tx;  ///< 20 n x n
  Vector td;  ///< 20 n
  Matrix qb;  ///< 20 n x 20 n
  Matrix h;   ///< 20 x 20
};
Condensed condense(const AxisProblem& problem);

/// The table of one quadratic program, without delay and set-point law.
template <typename T>
mpc::GainTable<T> make_gain_table(const AxisProblem& problem);

/// Prediction through the axis' transport delay.
template <typename T>
mpc::DelayModel<T> make_delay_model(const model::Vehicle& vehicle, Axis axis);

/// Both axes' tables of a vehicle, made in memory within milliseconds, without the set-point law (the preview law then
/// answers everything). `digest` is the vehicle file's. Throws std::domain_error when the model cannot be controlled.
template <typename T>
mpc::GainTables<T> make_gain_tables(const model::Vehicle& vehicle, const core::Sha256Digest& digest = {});

}  // namespace m100::tools::gains
