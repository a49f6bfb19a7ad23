// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "firmware/mpc/horizontal_mpc.h"
#include "host_tests/lab/gains/axis_model.h"
#include "host_tests/lab/gains/linear_program.h"
#include "host_tests/lab/gains/setpoint_law.h"

namespace m100::lab::gains {

/// Which of the 20 inputs are at a limit: +1 upper, -1 lower, 0 free. The name of a critical region.
using Sides = std::array<std::int8_t, mpc::kHorizon>;

/// The first input of a region: at a limit, or an affine function of the scaled parameters and the two residuals.
struct Piece {
  int side = 0;           ///< +1 or -1: at that limit, and the rest means nothing
  Eigen::VectorXd slope;  ///< one number per parameter, rad
  double constant = 0.0;  ///< rad
  double per_disturbance = 0.0;
  double per_input_target = 0.0;
};

/// Where one set of sides is optimal, and what the first input is there.
struct CriticalRegion {
  std::vector<HalfSpace> rows;  ///< those that cut the unit box; not only facets
  Piece piece;
};

/// The parametric program of a constant reference in scaled parameters s = z / box, one for each of the set-point law's
/// six numbers that the axis has (five without a tilt rate); the optimum without limits is u = uu s.
class ParametricProgram {
 public:
  /// Limits symmetric about 0; every length of the box positive.
  ParametricProgram(const AxisProblem& problem, const SetpointBox& box);

  /// How many parameters there are: 5 or 6. All vectors of parameters have this size.
  Eigen::Index size() const { return static_cast<Eigen::Index>(slots_.size()); }
  /// The number of the set-point law (SetpointTree) that parameter j is.
  std::size_t slot(Eigen::Index j) const { return slots_.at(static_cast<std::size_t>(j)); }
  double limit() const { return limit_; }
  const SetpointBox& box() const { return box_; }
  /// Normal of the plane that halves the box: what lies below it is the mirror image of what lies above.
  Eigen::VectorXd mirror() const { return uu_.row(0); }

  /// Which inputs are at which limit at the optimum for s.
  Sides sides_at(const Eigen::VectorXd& s);
  CriticalRegion region_of(const Sides& sides) const;

 private:
  Eigen::VectorXd optimum_of(Eigen::Index input, double constant) const;
  Eigen::MatrixXd multipliers_of(const Sides& sides, const std::vector<Eigen::Index>& active) const;

  SetpointBox box_;
  mpc::GainTable<double> table_;
  mpc::HorizontalMpc<double> controller_;
  double limit_;
  Eigen::MatrixXd inverse_;  ///< 20 x 20, H^-1
  Eigen::MatrixXd uu_;       ///< 20 x size()
  std::vector<std::size_t> slots_;
};

}  // namespace m100::lab::gains
