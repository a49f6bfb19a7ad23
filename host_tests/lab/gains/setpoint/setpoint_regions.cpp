// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/setpoint/setpoint_regions.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace m100::lab::gains {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kThinnest = 1e-9;  ///< a region whose inscribed ball has a smaller radius has no interior
constexpr double kNudge = 2e-6;     ///< distance across a facet at which the next region is searched
constexpr double kClear = 1e-6;     ///< ten times the tolerance of the linear programs
constexpr std::size_t kMaxRegions = 4000;

bool same_law(const Piece& a, const Piece& b) {
  return a.side == b.side && (a.side != 0 || ((b.slope - a.slope).cwiseAbs().maxCoeff() < 1e-9 &&
                                              std::abs(b.constant - a.constant) < 1e-9));
}

VectorXd farthest(Polytope& polytope, const VectorXd& direction) {
  VectorXd corner;
  polytope.maximise(direction, 1e300, &corner);
  return corner;
}

}  // namespace

Regions::Regions(ParametricProgram& program, const ConstructionContext& work) : program_(program), work_(work) {
  const Index n = program.size();
  for (Index i = 0; i < n; ++i) {
    domain_.push_back({VectorXd::Unit(n, i), 1.0});
    domain_.push_back({-VectorXd::Unit(n, i), 1.0});
  }
  domain_.push_back({-program.mirror() / program.mirror().norm(), 0.0});
  enqueue(program.sides_at(1e-3 * program.mirror() / program.mirror().norm()));
  while (!queue_.empty()) {
    if (regions_.size() > kMaxRegions) {
      throw TooLarge{};
    }
    const Sides sides = queue_.front();
    queue_.pop_front();
    explore(sides);
    work_.report_progress(regions_.size(), 0);
  }
  join_borders();
}

void Regions::enqueue(const Sides& sides) {
  if (known_.emplace(sides, SIZE_MAX).second) {
    queue_.push_back(sides);
  }
}

std::size_t Regions::piece_index(const Piece& piece) {
  const auto same =
      std::find_if(pieces_.begin(), pieces_.end(), [&piece](const Piece& other) { return same_law(other, piece); });
  const auto index = static_cast<std::size_t>(same - pieces_.begin());
  if (same == pieces_.end()) {
    pieces_.push_back(piece);
  }
  return index;
}

/// Makes the region of these sides, and queues the regions across its facets.
void Regions::explore(const Sides& sides) {
  const CriticalRegion critical = program_.region_of(sides);
  Polytope polytope(static_cast<std::size_t>(program_.size()), work_.budget());
  for (const HalfSpace& row : critical.rows) {
    polytope.add(row);
  }
  for (const HalfSpace& row : domain_) {
    polytope.add(row);
  }
  Region region;
  region.radius = polytope.radius(&region.centre);
  if (region.radius < kThinnest) {
    return;
  }
  for (Index i = 0; i < program_.size(); ++i) {
    for (const double sign : {1.0, -1.0}) {
      region.corners.push_back(farthest(polytope, sign * VectorXd::Unit(program_.size(), i)));
    }
  }
  // One question after the other of the same kind: the solver begins where the last one ended.
  std::vector<std::size_t> facets;
  for (std::size_t i = 0; i < critical.rows.size(); ++i) {
    const HalfSpace& row = critical.rows.at(i);
    if (region.bound(row.a) > row.b - kClear && polytope.is_facet(i, region.centre)) {
      facets.push_back(i);
      region.rows.push_back(row);
    }
  }
  for (const HalfSpace& facet : region.rows) {
    region.corners.push_back(farthest(polytope, -facet.a));
  }
  for (const std::size_t i : facets) {
    cross(polytope, i, critical.rows.at(i));
  }
  region.rows.insert(region.rows.end(), domain_.begin(), domain_.end());
  region.piece = piece_index(critical.piece);
  known_.at(sides) = regions_.size();
  regions_.push_back(std::move(region));
}

/// Finds the region across facet `row` of the region that is being explored.
void Regions::cross(Polytope& polytope, std::size_t row, const HalfSpace& facet) {
  VectorXd centre;
  polytope.radius(&centre, row);
  const VectorXd across = centre + kNudge * facet.a;
  if (across.cwiseAbs().maxCoeff() > 1.0 || program_.mirror().dot(across) < 0.0) {
    return;
  }
  const Sides next = program_.sides_at(across);
  enqueue(next);
  crossings_.push_back({regions_.size(), next, facet, {centre}});
}

void Regions::join_borders() {
  for (Crossing& crossing : crossings_) {
    const std::size_t to = known_.at(crossing.to);
    if (to == SIZE_MAX || regions_.at(crossing.from).piece == regions_.at(to).piece) {
      continue;
    }
    for (const std::size_t region : {crossing.from, to}) {
      for (const VectorXd& corner : regions_.at(region).corners) {
        if (std::abs(crossing.plane.a.dot(corner) - crossing.plane.b) < 1e-7) {
          crossing.points.push_back(corner);
        }
      }
    }
    borders_.push_back({crossing.from, to, crossing.plane, crossing.points});
  }
}

}  // namespace m100::lab::gains
