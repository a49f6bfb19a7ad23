// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/setpoint/setpoint_program.h"

#include <algorithm>

#include "firmware/core/assert.h"
#include "host_tests/lab/gains/gain_tables.h"

namespace m100::lab::gains {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kInputs = static_cast<Index>(mpc::kHorizon);
constexpr std::size_t kParameters = 6;  ///< parameters of the set-point law without the two residuals
constexpr std::size_t kTiltRate = 3;    ///< the parameter that a first-order axis does not have

int side_of(const Sides& sides, Index input) { return sides.at(static_cast<std::size_t>(input)); }

/// Adds a's <= b unless the whole unit box satisfies it.
void add_row(std::vector<HalfSpace>& rows, const VectorXd& a, double b) {
  const double size = a.norm();
  if (size > 1e-12 && b < a.cwiseAbs().sum()) {
    rows.push_back({a / size, b / size});
  }
}

}  // namespace

ParametricProgram::ParametricProgram(const AxisQp& problem, const SetpointBox& box)
    : box_(box),
      table_(make_gain_table(problem)),
      controller_(table_),
      limit_(static_cast<double>(problem.u_max)),
      inverse_(inverse(condense(problem).h).cast<double>()) {
  M100_ASSERT(problem.u_min == -problem.u_max && *std::min_element(box.begin(), box.end()) > 0.0);
  for (std::size_t slot = 0; slot < kParameters; ++slot) {
    if (slot != kTiltRate || table_.states == mpc::kMaxStates) {
      slots_.push_back(slot);
    }
  }
  uu_ = MatrixXd::Zero(kInputs, size());
  for (Index j = 0; j < size(); ++j) {
    for (std::size_t i = 0; i < mpc::kHorizon; ++i) {
      const double per_parameter = slot(j) < 4    ? table_.state_gain.at(slot(j) * mpc::kHorizon + i)
                                   : slot(j) == 4 ? table_.filter_gain.at(i) * table_.rate_weight
                                                  : 1.0;
      uu_(static_cast<Index>(i), j) = per_parameter * box_.at(slot(j));
    }
  }
}

Sides ParametricProgram::sides_at(const VectorXd& s) {
  M100_ASSERT(s.size() == size());
  std::array<double, kParameters> z{};
  for (Index j = 0; j < size(); ++j) {
    z.at(slot(j)) = s(j) * box_.at(slot(j));
  }
  mpc::Problem<double> problem;
  problem.state = {z[0], z[1], z[2], z[3]};
  problem.previous_input_slope = z[4] + z[5];
  problem.input_offset_slope = -z[5];
  problem.input_ref_slope.fill(z[5]);
  problem.constant_targets = true;
  mpc::Solution<double> solution;
  controller_.solve_preview(problem, solution);
  Sides sides{};
  for (std::size_t i = 0; i < mpc::kHorizon; ++i) {
    const double u = solution.input_slope.at(i);
    sides.at(i) = u >= limit_ - 1e-12 ? std::int8_t(1) : (u <= -limit_ + 1e-12 ? std::int8_t(-1) : std::int8_t(0));
  }
  return sides;
}

/// Coefficients of the optimum of one input without limits: slopes, a constant, and the gains of both residuals.
VectorXd ParametricProgram::optimum_of(Index input, double constant) const {
  const auto at = static_cast<std::size_t>(input);
  VectorXd out(size() + 3);
  out.head(size()) = uu_.row(input);
  out.tail(3) << constant, table_.disturbance_gain.at(at), table_.input_target_gain.at(at);
  return out;
}

/// Lagrange multipliers: one row for each active input, with the columns of optimum_of().
MatrixXd ParametricProgram::multipliers_of(const Sides& sides, const std::vector<Index>& active) const {
  const auto m = static_cast<Index>(active.size());
  Matrix waa(m, m);
  MatrixXd right(m, size() + 3);
  for (Index a = 0; a < m; ++a) {
    const Index i = active.at(static_cast<std::size_t>(a));
    for (Index b = 0; b < m; ++b) {
      waa(a, b) = inverse_(i, active.at(static_cast<std::size_t>(b)));
    }
    right.row(a) = optimum_of(i, -limit_ * side_of(sides, i)).transpose();
  }
  return m > 0 ? MatrixXd(solve(waa, right.cast<Real>()).cast<double>()) : right;
}

CriticalRegion ParametricProgram::region_of(const Sides& sides) const {
  std::vector<Index> active;
  for (Index i = 0; i < kInputs; ++i) {
    if (side_of(sides, i) != 0) {
      active.push_back(i);
    }
  }
  const MatrixXd multipliers = multipliers_of(sides, active);
  const MatrixXd of_active = inverse_(Eigen::all, active);
  CriticalRegion out;
  out.piece.side = side_of(sides, 0);
  Index a = 0;
  for (Index i = 0; i < kInputs; ++i) {
    if (const double side = side_of(sides, i); side != 0.0) {
      add_row(out.rows, -side * multipliers.row(a).head(size()).transpose(), side * multipliers(a, size()));
      ++a;
      continue;
    }
    VectorXd y = optimum_of(i, 0.0);
    y -= multipliers.transpose() * of_active.row(i).transpose();
    add_row(out.rows, y.head(size()), limit_ - y(size()));
    add_row(out.rows, -y.head(size()), limit_ + y(size()));
    if (i == 0) {
      out.piece.slope = y.head(size());
      out.piece.constant = y(size());
      out.piece.per_disturbance = y(size() + 1);
      out.piece.per_input_target = y(size() + 2);
    }
  }
  return out;
}

}  // namespace m100::lab::gains
