// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <vector>

#include "host_tests/lab/gains/setpoint/setpoint_program.h"

namespace m100::lab::gains {

/// Thrown for a vehicle whose law is too large for a table; it flies with the preview law alone.
using TooLarge = ComputeBudget::Exhausted;

/// The budget of a construction and the receiver of its progress. Both must outlive this object.
class ConstructionContext {
 public:
  ConstructionContext(ComputeBudget& budget, const SetpointProgress& progress) : budget_(budget), progress_(progress) {}
  ComputeBudget& budget() const { return budget_; }
  void report_progress(std::size_t regions, std::size_t planes) const {
    if (progress_) {
      progress_(regions, planes, budget_.spent());
    }
  }

 private:
  ComputeBudget& budget_;
  const SetpointProgress& progress_;
};

struct Region {
  std::size_t piece = 0;
  std::vector<HalfSpace> rows;  ///< its own facets, and all half-spaces of the domain
  std::vector<Eigen::VectorXd>
      corners;             ///< far points of the region in many directions, first along +x0, -x0, +x1, ...
  Eigen::VectorXd centre;  ///< of its largest inscribed ball
  double radius = 0.0;

  /// An upper bound of a'x over the region: its maximum over the smallest box around it.
  double bound(const Eigen::VectorXd& a) const {
    double out = 0.0;
    for (Eigen::Index i = 0; i < a.size(); ++i) {
      out += a(i) * corners.at(static_cast<std::size_t>(2 * i + (a(i) > 0.0 ? 0 : 1)))(i);
    }
    return out;
  }
};

/// A facet between two regions with different first inputs.
struct Border {
  std::size_t first, second;
  HalfSpace plane;
  std::vector<Eigen::VectorXd> points;
};

/// All critical regions that meet the unmirrored half of the box, found by crossing every facet.
class Regions {
 public:
  /// Throws TooLarge if there are too many regions or the budget is spent. Both arguments must outlive the object.
  Regions(ParametricProgram& program, const ConstructionContext& work);

  const std::vector<Region>& all() const { return regions_; }
  const std::vector<Piece>& pieces() const { return pieces_; }
  const std::vector<Border>& borders() const { return borders_; }
  const Piece& piece_of(std::size_t region) const { return pieces_.at(regions_.at(region).piece); }

 private:
  struct Crossing {
    std::size_t from;
    Sides to;
    HalfSpace plane;
    std::vector<Eigen::VectorXd> points;
  };

  void enqueue(const Sides& sides);
  std::size_t piece_index(const Piece& piece);
  void explore(const Sides& sides);
  void cross(Polytope& polytope, std::size_t row, const HalfSpace& facet);
  void join_borders();

  ParametricProgram& program_;
  const ConstructionContext& work_;
  std::vector<HalfSpace> domain_;
  std::map<Sides, std::size_t> known_;  ///< SIZE_MAX: not explored yet, or without an interior
  std::deque<Sides> queue_;
  std::vector<Region> regions_;
  std::vector<Piece> pieces_;
  std::vector<Crossing> crossings_;
  std::vector<Border> borders_;
};

}  // namespace m100::lab::gains
