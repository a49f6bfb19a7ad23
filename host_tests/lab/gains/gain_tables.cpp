// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/gain_tables.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "firmware/core/assert.h"
#include "firmware/mpc/table_data.h"

namespace m100::lab::gains {
namespace {

constexpr Eigen::Index kN = static_cast<Eigen::Index>(mpc::kHorizon);

template <std::size_t kSize>
void put(std::array<double, kSize>& to, const Matrix& from, std::size_t offset = 0) {
  const Real* data = from.data();  // column-major
  for (std::size_t i = 0; i < static_cast<std::size_t>(from.size()); ++i) {
    to.at(offset + i) = static_cast<double>(data[i]);
  }
}

/// The coefficients a_i of det(I - q A') = 1 + sum a_i q^i and the rows n_i' of B' q adj(I - q A') = sum n_i' q^i, by
/// Faddeev-LeVerrier: n_i' = B' (A'^(i-1) + a_1 A'^(i-2) + ... + a_(i-1) I) for i = 1..n.
struct Adjoint {
  Vector coefficients;
  Matrix taps;  ///< n x n, row i - 1 is n_i'
};
Adjoint adjoint(const DiscreteAxis& step) {
  const Eigen::Index n = step.a.rows();
  Adjoint out{Vector::Zero(n), Matrix::Zero(n, n)};
  Matrix m = Matrix::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    out.taps.row(i) = (m * step.b).transpose();
    const Matrix am = step.a * m;
    out.coefficients(i) = -am.trace() / Real(i + 1);
    m = am + out.coefficients(i) * Matrix::Identity(n, n);
  }
  return out;
}

/// Computes GainTable::clipping_gain from H^-1 by elimination.
void put_clipping_gain(mpc::GainTable<double>& out, Matrix rest) {
  std::size_t next = 0;
  for (Eigen::Index k = 0; k < kN; ++k) {
    const Vector column = rest.col(k) / rest(k, k);
    const Eigen::Index first = k - k % static_cast<Eigen::Index>(mpc::kPack);
    for (Eigen::Index i = first; i < kN; ++i) {
      out.clipping_gain.at(next++) = i < k ? 0.0 : static_cast<double>(column(i));
    }
    rest -= column * rest(k, k) * column.transpose();
  }
}

mpc::StepModel<double> step_model(const ContinuousAxis& axis, Real step_s) {
  const DiscreteAxis step = discretise(axis, step_s);
  mpc::StepModel<double> out;
  for (Eigen::Index row = 0; row < step.a.rows(); ++row) {
    for (Eigen::Index col = 0; col < step.a.cols(); ++col) {
      out.transition.at(static_cast<std::size_t>(row) * mpc::kMaxStates + static_cast<std::size_t>(col)) =
          static_cast<double>(step.a(row, col));
    }
    out.input.at(static_cast<std::size_t>(row)) = static_cast<double>(step.b(row));
    out.disturbance.at(static_cast<std::size_t>(row)) = static_cast<double>(step.bd(row));
  }
  return out;
}

}  // namespace

Condensed condense(const AxisQp& problem) {
  const Eigen::Index n = problem.step.a.rows();
  M100_ASSERT(problem.step.a.cols() == n && problem.step.b.size() == n && problem.step.bd.size() == n);
  M100_ASSERT(problem.q.size() == n && problem.p.rows() == n && problem.p.cols() == n);
  Condensed out{Matrix::Zero(kN * n, kN), Matrix::Zero(kN * n, n), Vector::Zero(kN * n), Matrix::Zero(kN, kN * n),
                Matrix::Zero(kN, kN)};
  Matrix tx = Matrix::Identity(n, n);
  Vector td = Vector::Zero(n);
  for (Eigen::Index k = 0; k < kN; ++k) {
    tx = problem.step.a * tx;
    td = problem.step.a * td + problem.step.bd;
    out.tx.middleRows(k * n, n) = tx;
    out.td.segment(k * n, n) = td;
    if (k > 0) {
      out.s.block(k * n, 0, n, kN) = problem.step.a * out.s.block((k - 1) * n, 0, n, kN);
    }
    out.s.block(k * n, k, n, 1) += problem.step.b;
    out.weighted.middleCols(k * n, n) = out.s.middleRows(k * n, n).transpose() * problem.q.asDiagonal();
  }
  // Added in the order of a product of whole matrices, which all tables have that were ever made.
  Matrix last = Matrix::Zero(kN * n, Eigen::Index(mpc::kMaxStates));
  last.bottomRightCorner(n, n) = problem.p;
  out.weighted.rightCols(n) = (out.s.transpose() * last).rightCols(n);
  Matrix difference = Matrix::Identity(kN, kN);
  difference.diagonal(-1).setConstant(-1);
  out.h =
      out.weighted * out.s + problem.r * Matrix::Identity(kN, kN) + problem.rd * difference.transpose() * difference;
  return out;
}

mpc::GainTable<double> make_gain_table(const AxisQp& problem) {
  const Eigen::Index n = problem.step.a.rows();
  if (n != 3 && n != 4) {
    throw std::domain_error("an axis has 3 or 4 states");
  }
  const Condensed condensed = condense(problem);
  const Matrix inverse_h = inverse(condensed.h);
  const Matrix from_states = inverse_h * condensed.weighted;
  const Adjoint a = adjoint(problem.step);
  Matrix c = Matrix::Identity(kN, kN);
  for (Eigen::Index i = 0; i < n; ++i) {
    c.diagonal(i + 1).setConstant(a.coefficients(i));
  }

  mpc::GainTable<double> out;
  out.states = static_cast<std::uint32_t>(n);
  out.input_min_slope = static_cast<double>(problem.u_min);
  out.input_max_slope = static_cast<double>(problem.u_max);
  out.tilt_sign = static_cast<double>(problem.tilt_sign);
  out.acceleration_per_tilt = static_cast<double>(problem.acceleration_per_tilt);
  out.drag_per_s = static_cast<double>(problem.drag_per_s);
  out.input_gain = static_cast<double>(problem.input_gain);
  out.rate_weight = static_cast<double>(problem.rd);
  Vector last_velocity = Vector::Zero(n);
  Vector last_tilt = Vector::Zero(n);
  last_velocity(1) = 1;
  last_tilt(2) = 1;
  const Matrix extra = problem.p - Matrix(problem.q.asDiagonal());
  put(out.position_taps, a.taps.col(0) * problem.q(0));
  put(out.velocity_taps, a.taps.col(1) * problem.q(1));
  put(out.tilt_taps, a.taps.col(2) * problem.q(2));
  out.input_taps[0] = static_cast<double>(problem.r);
  put(out.input_taps, a.coefficients * problem.r, 1);
  const auto behind = static_cast<std::size_t>(mpc::kMaxStates) - static_cast<std::size_t>(n);
  put(out.terminal_velocity_taps, (a.taps * extra * last_velocity).reverse(), behind);
  put(out.terminal_tilt_taps, (a.taps * extra * last_tilt).reverse(), behind);

  put(out.state_gain, -from_states * condensed.tx);
  put(out.disturbance_gain, -from_states * condensed.td);
  put(out.tilt_target_gain, from_states * last_tilt.replicate(kN, 1));
  put(out.input_target_gain, inverse_h * Vector::Constant(kN, problem.r));
  put(out.filter_gain, inverse_h * inverse(c));
  put(out.hessian, condensed.h);
  for (std::size_t i = 0; i < mpc::kHorizon; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      out.inverse_hessian.at(mpc::packed_row(i) + j) =
          static_cast<double>(inverse_h(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
    }
  }
  put_clipping_gain(out, inverse_h);
  return out;
}

mpc::DelayModel<double> make_delay_model(const model::Vehicle& vehicle, Axis axis) {
  const model::StickAxis& attitude = attitude_of(vehicle, axis);
  const ContinuousAxis continuous = continuous_axis(vehicle, axis);
  constexpr Real kTick_s = Real(0.01);
  mpc::DelayModel<double> out;
  // A delay that is a whole number of ticks except for rounding gets no fractional part.
  out.ticks = static_cast<std::uint32_t>(std::floor(Real(attitude.transport_delay_s) / kTick_s + Real(1e-6)));
  out.delay_s = static_cast<double>(attitude.transport_delay_s);
  out.rest = step_model(continuous, std::max(Real(0), Real(attitude.transport_delay_s) - Real(out.ticks) * kTick_s));
  out.tick = step_model(continuous, kTick_s);
  const Real zero = attitude.lead_zero_s;
  const Real w = attitude.natural_frequency_rad_s;
  out.lead.zero_s = static_cast<double>(zero);
  if (attitude.is_first_order()) {
    out.lead.share = static_cast<double>(zero / Real(attitude.time_constant_s));
  } else {
    out.lead.rate_gain =
        static_cast<double>(1 / (1 - 2 * Real(attitude.damping_ratio) * w * zero + w * w * zero * zero));
    out.lead.jump = static_cast<double>(zero * w * w);
  }
  return out;
}

mpc::GainTable<double> make_axis_table(const model::Vehicle& identified, Axis axis) {
  const model::Vehicle vehicle = model::controller_model(identified);
  mpc::GainTable<double> table = make_gain_table(axis_qp(vehicle, axis));
  table.delay = make_delay_model(vehicle, axis);
  return table;
}

mpc::GainTables<double> make_gain_tables(const model::Vehicle& identified, const core::Sha256Digest& digest) {
  mpc::GainTables<double> out{.x = make_axis_table(identified, Axis::kX), .y = make_axis_table(identified, Axis::kY)};
  out.x.vehicle = out.y.vehicle = digest;
  return out;
}

mpc::GainTable<float> to_float(const mpc::GainTable<double>& table) {
  std::array<double, mpc::kTableNumbers> list;
  std::size_t next = 0;
  mpc::visit_numbers(table, [&](const char*, const auto& numbers) {
    if constexpr (std::is_arithmetic_v<std::remove_cvref_t<decltype(numbers)>>) {
      list.at(next++) = static_cast<double>(numbers);
    } else {
      std::copy(numbers.begin(), numbers.end(), list.begin() + static_cast<std::ptrdiff_t>(next));
      next += numbers.size();
    }
  });
  return mpc::table_of<float>(list, table.vehicle);
}

}  // namespace m100::lab::gains
