// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/setpoint/setpoint_tree.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "firmware/mpc/table_file.h"

namespace m100::lab::gains {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kThin = 1e-7;     ///< balls below this radius are boundaries, not regions
constexpr double kOverlap = 1e-5;  ///< balls below this radius may be rounding where regions overlap
constexpr double kSame = 1e-7;     ///< planes whose numbers differ by less are one
constexpr std::uint32_t kDeepestTree = 48;
constexpr std::size_t kMaxPlanes = 3000;

using Numbers = std::vector<std::size_t>;  ///< of regions or of borders
using Cell = std::vector<HalfSpace>;

/// The part of a region that lies in a cell, with a ball inside it.
struct Part {
  std::size_t region = 0;
  VectorXd centre;
  double radius = 0.0;
};
using Parts = std::vector<Part>;

HalfSpace opposite(const HalfSpace& half) { return {-half.a, -half.b}; }

bool parallel(const HalfSpace& one, const HalfSpace& other) {
  return (one.a - other.a).norm() < kSame || (one.a + other.a).norm() < kSame;
}

/// Whether both half-spaces have the same plane, in either orientation.
bool same_plane(const HalfSpace& one, const HalfSpace& other) {
  return ((one.a - other.a).norm() < kSame && std::abs(one.b - other.b) < kSame) ||
         ((one.a + other.a).norm() < kSame && std::abs(one.b + other.b) < kSame);
}

Numbers count_up(std::size_t count) {
  Numbers out(count);
  std::iota(out.begin(), out.end(), std::size_t{0});
  return out;
}

/// The search tree over the regions, built from the root down.
class Splitting {
 public:
  Splitting(const Regions& regions, const ParametricProgram& program, const ConstructionContext& work,
            SetpointRows& out)
      : regions_(regions), program_(program), work_(work), out_(out) {
    const std::vector<double> mirror = row({program.mirror() / program.mirror().norm(), 0.0});
    std::copy(mirror.begin() + 1, mirror.end(), out.mirror.begin());
    Cell cell;
    Parts parts;
    for (const Region& region : regions.all()) {
      parts.push_back({parts.size(), region.centre, region.radius});
    }
    build(cell, parts, count_up(regions.borders().size()), 1);
  }
  const std::vector<SplitPlane>& planes() const { return planes_; }

 private:
  std::uint16_t leaf(std::size_t piece) { return static_cast<std::uint16_t>(kLeaf + put_law(piece)); }

  std::uint16_t build(Cell& cell, const Parts& regions, const Numbers& borders, std::uint32_t depth) {
    std::size_t piece = 0;
    if (is_leaf(cell, regions, piece)) {
      return leaf(piece);
    }
    if (planes_.size() >= kMaxPlanes || depth > kDeepestTree) {
      throw TooLarge{};
    }
    HalfSpace plane;
    if (!borders.empty()) {
      plane = best_plane(regions, borders);
    } else if (!parting_plane(cell, regions, plane)) {
      return leaf(regions_.all().at(solid_region(cell, regions)).piece);
    }
    work_.report_progress(regions_.all().size(), planes_.size());
    const auto node = static_cast<std::uint16_t>(planes_.size());
    planes_.push_back({row(plane), {}});
    out_.borders = std::max<std::size_t>(out_.borders, depth);
    for (const std::size_t side : {0U, 1U}) {
      const HalfSpace half = side == 0 ? plane : opposite(plane);
      const Parts kept = parts_in(cell, half, regions);
      const Numbers kept_borders = borders_between(kept, borders, plane);
      cell.push_back(half);
      const std::uint16_t child = build(cell, kept, kept_borders, depth + 1);
      cell.pop_back();
      planes_.at(node).child.at(side) = child;
    }
    return node;
  }

  Parts parts_in(const Cell& cell, const HalfSpace& half, const Parts& regions) const {
    Parts out;
    for (const Part& part : regions) {
      out.push_back(part);
      if (!cut(out.back(), cell, half)) {
        out.pop_back();
      }
    }
    return out;
  }
  /// The borders that lie between two of the regions, without those on the splitting plane.
  Numbers borders_between(const Parts& regions, const Numbers& borders, const HalfSpace& plane) const {
    std::set<std::size_t> here;
    std::ranges::transform(regions, std::inserter(here, here.end()), &Part::region);
    Numbers out;
    std::copy_if(borders.begin(), borders.end(), std::back_inserter(out), [&](std::size_t border) {
      const Border& b = regions_.borders().at(border);
      const bool parted = parallel(b.plane, plane) && std::abs(std::abs(b.plane.b) - std::abs(plane.b)) < kSame;
      return here.contains(b.first) && here.contains(b.second) && !parted;
    });
    return out;
  }

  /// Whether one clipped law serves all regions in the cell.
  /// @param piece receives that law.
  bool is_leaf(const Cell& cell, const Parts& regions, std::size_t& piece) const {
    std::set<std::size_t> found;
    std::set<std::size_t> affine;
    for (const auto& [region, centre, radius] : regions) {
      found.insert(regions_.all().at(region).piece);
      if (regions_.piece_of(region).side == 0) {
        affine.insert(regions_.all().at(region).piece);
      }
    }
    if (found.size() <= 1) {
      piece = found.empty() ? regions_.all().front().piece : *found.begin();
      return true;
    }
    if (affine.size() != 1) {
      return false;
    }
    piece = *affine.begin();
    const Piece& law = regions_.pieces().at(piece);
    return std::all_of(regions.begin(), regions.end(), [&](const Part& part) {
      const int side = regions_.piece_of(part.region).side;
      return side == 0 || saturates(part.region, cell, law, side);
    });
  }

  /// Whether the affine piece is beyond the limit of `side` everywhere in the part of the region inside the cell.
  bool saturates(std::size_t region, const Cell& cell, const Piece& affine, int side) const {
    const double bound = program_.limit() - side * affine.constant;  // side * slope s >= bound wanted
    for (const VectorXd& corner : regions_.all().at(region).corners) {
      const bool inside = std::all_of(cell.begin(), cell.end(),
                                      [&corner](const HalfSpace& half) { return half.a.dot(corner) <= half.b - 1e-9; });
      if (inside && side * affine.slope.dot(corner) < bound - 1e-7) {
        return false;  // a counterexample: no linear program needed
      }
    }
    Polytope polytope(static_cast<std::size_t>(program_.size()), work_.budget());
    fill(polytope, region, cell);
    return -polytope.maximise(-side * affine.slope, -bound) >= bound - 1e-9;
  }

  /// Fills the polytope with the part of a region that lies in the cell.
  void fill(Polytope& polytope, std::size_t region, const Cell& cell) const {
    for (const HalfSpace& row : regions_.all().at(region).rows) {
      polytope.add(row);
    }
    for (const HalfSpace& row : cell) {
      polytope.add(row);
    }
  }

  /// Cuts the part off at a plane of its cell. @returns false: nothing is left of it. A linear program is needed only
  /// where the known ball does not reach into the half-space, and neither the box around the region nor one of its
  /// facets keeps the region out of it.
  bool cut(Part& part, const Cell& cell, const HalfSpace& half) const {
    const Region& region = regions_.all().at(part.region);
    if (-region.bound(-half.a) > half.b || std::ranges::any_of(region.rows, [&half](const HalfSpace& row) {
          return half.b + row.b < kThin && (row.a + half.a).norm() < kSame;
        })) {
      return false;
    }
    part.radius = std::min(part.radius, half.b - half.a.dot(part.centre));
    if (part.radius <= kThin) {
      Polytope polytope(static_cast<std::size_t>(program_.size()), work_.budget());
      fill(polytope, part.region, cell);
      polytope.add(half);
      part.radius = polytope.radius(&part.centre);
    }
    return part.radius > kThin;
  }

  /// The number of regions on the side of the plane that has more of them.
  std::size_t fuller_side(const Cell& cell, const Parts& regions, const HalfSpace& plane) const {
    return std::max(parts_in(cell, plane, regions).size(), parts_in(cell, opposite(plane), regions).size());
  }

  /// Chooses the plane that splits a cell in which no border between regions is left: of all half-spaces of the regions
  /// the one with the fewest regions on its fuller side. @returns false: none of them separates the regions.
  bool parting_plane(const Cell& cell, const Parts& regions, HalfSpace& best) const {
    std::size_t fewest = regions.size();
    for (const Part& owner : regions) {
      for (const HalfSpace& row : regions_.all().at(owner.region).rows) {
        const std::size_t fuller = fuller_side(cell, regions, row);
        if (fuller < fewest) {
          fewest = fuller;
          best = row;
        }
      }
    }
    return fewest < regions.size();
  }

  /// The largest of regions that no facet separates: they overlap only by rounding. Throws TooLarge if two are solid.
  std::size_t solid_region(const Cell& cell, const Parts& regions) const {
    std::size_t real = regions.front().region;
    double largest = 0.0;
    double second = 0.0;
    for (const auto& [region, centre, inner] : regions) {
      Polytope polytope(static_cast<std::size_t>(program_.size()), work_.budget());
      fill(polytope, region, cell);
      const double radius = polytope.radius();
      second = std::max(second, std::min(radius, largest));
      real = radius > largest ? region : real;
      largest = std::max(largest, radius);
    }
    if (second > kOverlap) {
      throw TooLarge{};
    }
    return real;
  }

  /// The plane of a border with the least score_of().
  HalfSpace best_plane(const Parts& regions, const Numbers& borders) const {
    std::vector<HalfSpace> candidates;
    for (const std::size_t border : borders) {
      const HalfSpace& plane = regions_.borders().at(border).plane;
      work_.budget().compare(candidates.size());
      if (std::none_of(candidates.begin(), candidates.end(),
                       [&plane](const HalfSpace& other) { return same_plane(other, plane); })) {
        candidates.push_back(plane);
      }
    }
    double best_score = 1e300;
    std::size_t best = 0;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      const double score = score_of(candidates.at(c), regions, borders);
      if (score < best_score) {
        best_score = score;
        best = c;
      }
    }
    return candidates.at(best);
  }

  /// The score of a plane from the number of borders and regions left on its sides; less is better.
  double score_of(const HalfSpace& plane, const Parts& regions, const Numbers& borders) const {
    double low = 0;
    double high = 0;
    for (const std::size_t border : borders) {
      const auto [below, above] = sides_of(plane, regions_.borders().at(border).points);
      low += below ? 1 : 0;
      high += above ? 1 : 0;
    }
    double low_regions = 0;
    double high_regions = 0;
    for (const Part& part : regions) {
      const auto [below, above] = sides_of(plane, regions_.all().at(part.region).corners);
      low_regions += below ? 1 : 0;
      high_regions += above ? 1 : 0;
    }
    return std::max(low, high) + 0.3 * (low + high) + 0.05 * std::max(low_regions, high_regions) +
           (std::min(low_regions, high_regions) < 1 ? 1e6 : 0.0);
  }
  /// Whether a point is below the plane, and whether one is above it.
  std::pair<bool, bool> sides_of(const HalfSpace& plane, const std::vector<VectorXd>& points) const {
    work_.budget().compare(points.size());
    bool below = false;
    bool above = false;
    for (const VectorXd& point : points) {
      const double at = plane.a.dot(point) - plane.b;
      below = below || at < -1e-7;
      above = above || at > 1e-7;
    }
    return {below, above};
  }

  /// The plane of the half-space in the table's units; it is positive outside the half-space.
  std::vector<double> row(const HalfSpace& plane) const {
    std::vector<double> out(mpc::kPlaneNumbers, 0.0);
    out.at(0) = -plane.b;
    for (Index j = 0; j < program_.size(); ++j) {
      const std::size_t slot = program_.slot(j);
      out.at(1 + slot) = plane.a(j) / program_.box().at(slot);
    }
    return out;
  }
  std::size_t put_law(std::size_t piece) {
    const auto known = laws_.find(piece);
    if (known != laws_.end()) {
      return known->second;
    }
    const Piece& p = regions_.pieces().at(piece);
    std::array<double, mpc::kLawNumbers> numbers{};
    numbers.back() = p.side != 0 ? p.side * program_.limit() : p.constant;
    for (Index j = 0; j < program_.size() && p.side == 0; ++j) {
      const std::size_t slot = program_.slot(j);
      numbers.at(slot) = p.slope(j) / program_.box().at(slot);
    }
    numbers.at(6) = p.per_disturbance;
    numbers.at(7) = p.per_input_target;
    if (out_.laws.size() / mpc::kLawNumbers >= mpc::kMaxSetpointLaws) {
      throw TooLarge{};
    }
    out_.laws.insert(out_.laws.end(), numbers.begin(), numbers.end());
    laws_[piece] = out_.laws.size() / mpc::kLawNumbers - 1;
    return laws_[piece];
  }

  const Regions& regions_;
  const ParametricProgram& program_;
  const ConstructionContext& work_;
  SetpointRows& out_;
  std::vector<SplitPlane> planes_;
  std::map<std::size_t, std::size_t> laws_;
};

}  // namespace

std::vector<SplitPlane> split_box(const Regions& regions, const ParametricProgram& program,
                                  const ConstructionContext& work, SetpointRows& out) {
  return Splitting(regions, program, work, out).planes();
}

}  // namespace m100::lab::gains
