// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "firmware/core/eigen.h"

struct glp_prob;

namespace m100::tools::gains {

/// A half-space a's <= b of scaled parameters, |a| = 1.
struct HalfSpace {
  Eigen::VectorXd a;
  double b = 0.0;
};

/// A polytope, asked by linear programs. All parameters lie in [-1, 1].
class Polytope {
 public:
  explicit Polytope(std::size_t dimensions);
  ~Polytope();
  Polytope(const Polytope&) = delete;
  Polytope& operator=(const Polytope&) = delete;

  void add(const HalfSpace& half_space);
  void drop_last();
  std::size_t size() const { return count_; }

  /// Largest value of a's and where; -infinity when the polytope is empty. `decision`: when the value is within 1e-8 of
  /// it, the program is solved once more in rational arithmetic.
  double maximise(const Eigen::VectorXd& a, double decision, Eigen::VectorXd* where = nullptr);
  /// Radius of the largest ball inside (negative: empty) and its centre; with `on`, the ball of that facet.
  double radius(Eigen::VectorXd* centre = nullptr, std::size_t on = SIZE_MAX);
  /// Whether half-space i carries a facet.
  bool is_facet(std::size_t i);

 private:
  int solve(double decision);

  glp_prob* program_;
  std::size_t dimensions_;
  std::size_t count_ = 0;
  std::vector<HalfSpace> rows_;
};

}  // namespace m100::tools::gains
