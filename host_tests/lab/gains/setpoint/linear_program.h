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

/// The computing budget of a construction. It is counted, not timed, so that every machine gets the same result.
/// program() and compare() throw Exhausted if it is spent.
class ComputeBudget {
 public:
  struct Exhausted {};
  /// Maximum number of simplex steps in one run of the solver.
  static constexpr int kPivots = 2000;

  /// @param comparisons tests of one point or plane against one plane.
  explicit ComputeBudget(std::uint64_t programs = 400'000, std::uint64_t comparisons = 2'000'000'000)
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
  /// The spent part of the budget: the larger of both ratios.
  double spent() const {
    return std::max(static_cast<double>(programs_spent_) / static_cast<double>(programs_),
                    static_cast<double>(comparisons_spent_) / static_cast<double>(comparisons_));
  }

 private:
  std::uint64_t programs_, comparisons_;
  std::uint64_t programs_spent_ = 0, comparisons_spent_ = 0;
};

/// A polytope within the box [-1, 1] of every parameter, examined by linear programs.
class Polytope {
 public:
  /// Precondition: at least one dimension. The budget must outlive the polytope.
  Polytope(std::size_t dimensions, ComputeBudget& budget);
  ~Polytope();
  Polytope(const Polytope&) = delete;
  Polytope& operator=(const Polytope&) = delete;

  /// Adds a half-space, which gets the next number, starting with 0. Its vector a has one entry per dimension.
  void add(const HalfSpace& half_space);

  // Each of these functions spends at most one linear program of the budget; throws ComputeBudget::Exhausted if none is
  // left or rational arithmetic takes more than kPivots steps.

  /// The maximum of the scalar product a's over the polytope, and in `where` the point of the maximum; -infinity: the
  /// polytope is empty. Rational arithmetic is used if floating point fails or gives a value within 1e-8 of `decision`.
  double maximise(const Eigen::VectorXd& a, double decision, Eigen::VectorXd* where = nullptr);
  /// Radius (negative: empty) and centre of the largest inscribed ball; with `on`, of that with its centre on this
  /// facet.
  double radius(Eigen::VectorXd* centre = nullptr, std::size_t on = SIZE_MAX);
  /// Whether half-space i defines a facet. `on` and `i` are numbers of added half-spaces, `inside` is a point of the
  /// polytope: no linear program is needed if the way from it to half-space i reaches no other one before.
  bool is_facet(std::size_t i, const Eigen::VectorXd& inside);

 private:
  void put_row(int row, const HalfSpace& half_space, double ball);
  int solve(double decision);
  /// How far the polytope without half-space i reaches beyond it from a point inside, straight on.
  double reach_beyond(std::size_t i, const Eigen::VectorXd& inside) const;

  glp_prob* program_;
  ComputeBudget& budget_;
  std::size_t dimensions_;
  std::vector<HalfSpace> rows_;
};

}  // namespace m100::lab::gains
