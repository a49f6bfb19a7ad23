// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "firmware/mpc/horizontal_mpc.h"
#include "host_tests/lab/gains/axis_model.h"
#include "host_tests/lab/gains/setpoint/linear_program.h"
#include "host_tests/lab/gains/setpoint/setpoint_law.h"

namespace m100::lab::gains {

/// Which of the 20 inputs are at a limit: +1 upper, -1 lower, 0 free. Identifies a critical region.
using Sides = std::array<std::int8_t, mpc::kHorizon>;

/// The first input of a region: at a limit, or an affine function of the scaled parameters and the two residuals.
struct Piece {
  int side = 0;           ///< +1 or -1: at the upper or lower limit, the other members are unused; 0: affine
  Eigen::VectorXd slope;  ///< one number per parameter, rad
  double constant = 0.0;  ///< rad
  double per_disturbance = 0.0;
  double per_input_target = 0.0;
};

/// The region in which one set of sides is optimal, and the first input in it.
struct CriticalRegion {
  std::vector<HalfSpace> rows;  ///< the half-spaces that cut the unit box; not only facets
  Piece piece;
};

/// The quadratic program for a constant reference, in the scaled parameters s = z / box. z are the first six parameters
/// that SetpointBox names; an axis without a tilt rate has five. The optimum without limits is linear in s.
class ParametricProgram {
 public:
  /// Preconditions: limits symmetric about 0; every length of the box positive.
  ParametricProgram(const AxisQp& problem, const SetpointBox& box);

  /// The number of parameters: 5 or 6. All vectors of parameters have this size.
  Eigen::Index size() const { return static_cast<Eigen::Index>(slots_.size()); }
  /// The index in the set-point law (SetpointTree) of parameter j.
  std::size_t slot(Eigen::Index j) const { return slots_.at(static_cast<std::size_t>(j)); }
  double limit() const { return limit_; }
  const SetpointBox& box() const { return box_; }
  /// Normal of the plane that halves the box; the half below it is the mirror image of the half above.
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
