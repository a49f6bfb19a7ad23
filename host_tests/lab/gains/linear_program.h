// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "firmware/core/eigen.h"

struct glp_prob;

namespace m100::lab::gains {

/// A half-space a's <= b of scaled parameters, |a| = 1.
struct HalfSpace {
  Eigen::VectorXd a;
  double b = 0.0;
};

/// What a construction may still cost. Counted, not timed, so that every machine comes to the same end: an undertaking
/// that has spent its allowance throws Exhausted.
class Allowance {
 public:
  struct Exhausted {};
  /// At most kPivots simplex steps each; a comparison is one point on one side of a plane.
  static constexpr int kPivots = 2000;

  explicit Allowance(std::uint64_t programs = 400'000, std::uint64_t comparisons = 2'000'000'000)
      : programs_(programs), comparisons_(comparisons) {}

  void program() {
    if (++programs_spent_ > programs_) {
      throw Exhausted{};
    }
  }
  void compare(std::uint64_t count) {
    comparisons_spent_ += count;
    if (comparisons_spent_ > comparisons_) {
      throw Exhausted{};
    }
  }
  std::uint64_t programs_spent() const { return programs_spent_; }
  std::uint64_t comparisons_spent() const { return comparisons_spent_; }
  /// The larger of both shares.
  double spent() const {
    return std::max(static_cast<double>(programs_spent_) / static_cast<double>(programs_),
                    static_cast<double>(comparisons_spent_) / static_cast<double>(comparisons_));
  }

 private:
  std::uint64_t programs_, comparisons_;
  std::uint64_t programs_spent_ = 0, comparisons_spent_ = 0;
};

/// A polytope, asked by linear programs. All parameters lie in [-1, 1].
class Polytope {
 public:
  /// At least one dimension. The allowance must outlive it.
  Polytope(std::size_t dimensions, Allowance& allowance);
  ~Polytope();
  Polytope(const Polytope&) = delete;
  Polytope& operator=(const Polytope&) = delete;

  /// The half-space gets the next number, from 0 on; its a has as many numbers as there are dimensions.
  void add(const HalfSpace& half_space);

  // Each of these is one linear program of the allowance, and throws Allowance::Exhausted when that is spent.

  /// Largest value of a's and where, a as in add(); -infinity when the polytope is empty. `decision`: when the value is
  /// within 1e-8 of it, the program is solved once more in rational arithmetic.
  double maximise(const Eigen::VectorXd& a, double decision, Eigen::VectorXd* where = nullptr);
  /// Radius of the largest ball inside (negative: empty) and its centre; with `on`, the ball of that facet.
  double radius(Eigen::VectorXd* centre = nullptr, std::size_t on = SIZE_MAX);
  /// Whether half-space i carries a facet. `on` and `i` are numbers of half-spaces that were added.
  bool is_facet(std::size_t i);

 private:
  int solve(double decision);

  glp_prob* program_;
  Allowance& allowance_;
  std::size_t dimensions_;
  std::vector<HalfSpace> rows_;
};

}  // namespace m100::lab::gains
