// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/tools/gains/setpoint_law.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <memory>
#include <set>

#include "firmware/mpc/horizontal_mpc.h"
#include "firmware/mpc/table_file.h"
#include "host_tests/tools/gains/gain_tables.h"
#include "host_tests/tools/gains/linear_program.h"

namespace m100::tools::gains {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Sides = std::array<std::int8_t, mpc::kHorizon>;

constexpr double kThin = 1e-7;     ///< balls below this radius are boundaries, not regions
constexpr double kOverlap = 1e-5;  ///< balls below this radius may be rounding where regions overlap
constexpr double kNudge = 2e-6;    ///< how far across a facet the next region is looked for
constexpr Index kInputs = static_cast<Index>(mpc::kHorizon);

/// The first input of a region: at a limit, or an affine function of the scaled parameters and the two residuals.
struct Piece {
  int side = 0;
  VectorXd slope;
  double constant = 0.0;
  double per_disturbance = 0.0;
  double per_input_target = 0.0;
};

struct Region {
  std::size_t piece = 0;
  std::vector<HalfSpace> rows;    ///< facets only, the domain's included
  std::vector<VectorXd> corners;  ///< far points of the region in many directions
};

/// A facet between two regions with different first inputs.
struct Border {
  std::size_t first, second;
  HalfSpace plane;
  std::vector<VectorXd> points;
};

/// The parametric program in scaled parameters s = z / box: which of the six there are, optimum without limits u = uu
/// s.
class Parametric {
 public:
  Parametric(const AxisProblem& problem, const SetpointBox& box)
      : box_(box),
        table_(make_gain_table(problem)),
        controller_(table_),
        limit_(static_cast<double>(problem.u_max)),
        inverse_(inverse(condense(problem).h).cast<double>()) {
    for (Index slot = 0; slot < 6; ++slot) {
      if (slot != 3 || table_.states == 4) {
        slots_.push_back(slot);
      }
    }
    uu_ = MatrixXd::Zero(kInputs, size());
    for (Index j = 0; j < size(); ++j) {
      const auto slot = static_cast<std::size_t>(slots_.at(static_cast<std::size_t>(j)));
      for (std::size_t i = 0; i < mpc::kHorizon; ++i) {
        const double per_parameter = slot < 4    ? table_.state_gain.at(slot * mpc::kHorizon + i)
                                     : slot == 4 ? table_.filter_gain.at(i) * table_.rate_weight
                                                 : 1.0;
        uu_(static_cast<Index>(i), j) = per_parameter * box_.at(slot);
      }
    }
  }

  Index size() const { return static_cast<Index>(slots_.size()); }
  const std::vector<Index>& slots() const { return slots_; }
  VectorXd mirror() const { return uu_.row(0); }

  /// Which inputs are at which limit at the optimum.
  Sides sides_at(const VectorXd& s) {
    std::array<double, 6> z{};
    for (Index j = 0; j < size(); ++j) {
      const auto slot = static_cast<std::size_t>(slots_.at(static_cast<std::size_t>(j)));
      z.at(slot) = s(j) * box_.at(slot);
    }
    mpc::Problem<double> problem;
    problem.state = {z[0], z[1], z[2], z[3]};
    problem.previous_input_rad = z[4] + z[5];
    problem.input_offset_rad = -z[5];
    problem.input_ref_rad.fill(z[5]);
    problem.constant_targets = true;
    mpc::Solution<double> solution;
    controller_.solve_preview(problem, solution);
    Sides sides{};
    for (std::size_t i = 0; i < mpc::kHorizon; ++i) {
      const double u = solution.input_rad.at(i);
      sides.at(i) = u >= limit_ - 1e-12 ? std::int8_t(1) : (u <= -limit_ + 1e-12 ? std::int8_t(-1) : std::int8_t(0));
    }
    return sides;
  }

  /// Rows of the critical region and the first input in it.
  std::pair<std::vector<HalfSpace>, Piece> region_of(const Sides& sides) const {
    std::vector<Index> active;
    for (Index i = 0; i < kInputs; ++i) {
      if (sides.at(static_cast<std::size_t>(i)) != 0) {
        active.push_back(i);
      }
    }
    const auto m = static_cast<Index>(active.size());
    Matrix waa(m, m);
    MatrixXd wfa(kInputs, m);
    MatrixXd right(m, size() + 3);  // slopes, constant, disturbance, input target
    for (Index a = 0; a < m; ++a) {
      const Index i = active.at(static_cast<std::size_t>(a));
      const auto at = static_cast<std::size_t>(i);
      for (Index b = 0; b < m; ++b) {
        waa(a, b) = inverse_(i, active.at(static_cast<std::size_t>(b)));
      }
      wfa.col(a) = inverse_.col(i);
      right.row(a).head(size()) = uu_.row(i);
      right.row(a).tail(3) << -limit_ * sides.at(at), table_.disturbance_gain.at(at), table_.input_target_gain.at(at);
    }
    const MatrixXd lambda = m > 0 ? MatrixXd(solve(waa, right.cast<Real>()).cast<double>()) : right;
    std::vector<HalfSpace> rows;
    const auto add = [&rows](const VectorXd& a, double b) {
      const double size = a.norm();
      if (size > 1e-12 && b < a.cwiseAbs().sum()) {  // else the unit box has it anyway
        rows.push_back({a / size, b / size});
      }
    };
    Piece piece;
    piece.side = sides[0];
    Index a = 0;
    for (Index i = 0; i < kInputs; ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (sides.at(at) != 0) {
        const VectorXd slope = -double(sides.at(at)) * lambda.row(a).head(size()).transpose();
        add(slope, double(sides.at(at)) * lambda(a, size()));
        ++a;
        continue;
      }
      VectorXd y = VectorXd::Zero(size() + 3);
      y.head(size()) = uu_.row(i);
      y.tail(3) << 0.0, table_.disturbance_gain.at(at), table_.input_target_gain.at(at);
      y -= lambda.transpose() * wfa.row(i).transpose();
      add(y.head(size()), limit_ - y(size()));
      add(-y.head(size()), limit_ + y(size()));
      if (i == 0) {
        piece.slope = y.head(size());
        piece.constant = y(size());
        piece.per_disturbance = y(size() + 1);
        piece.per_input_target = y(size() + 2);
      }
    }
    return {rows, piece};
  }
  double limit() const { return limit_; }
  const SetpointBox& box() const { return box_; }

 private:
  SetpointBox box_;
  mpc::GainTable<double> table_;
  mpc::HorizontalMpc<double> controller_;
  double limit_;
  MatrixXd inverse_;
  MatrixXd uu_;
  std::vector<Index> slots_;
};

/// A vehicle whose law is too large for a table: it flies by the preview law alone.
using TooLarge = Allowance::Exhausted;
constexpr std::size_t kMostRegions = 4000;
constexpr std::uint32_t kDeepestTree = 48;
constexpr std::size_t kMostPlanes = 3000;

/// What the construction may cost, and who is told how far it is.
class Undertaking {
 public:
  Undertaking(Allowance& allowance, const SetpointProgress& progress) : allowance_(allowance), progress_(progress) {}
  Allowance& allowance() const { return allowance_; }
  void tell(std::size_t regions, std::size_t planes) const {
    if (progress_) {
      progress_(regions, planes, allowance_.spent());
    }
  }

 private:
  Allowance& allowance_;
  const SetpointProgress& progress_;
};

/// All critical regions that meet the unmirrored half of the box.
class Regions {
 public:
  Regions(Parametric& program, const Undertaking& work) : program_(program), work_(work) {
    const Index n = program.size();
    for (Index i = 0; i < n; ++i) {
      domain_.push_back({VectorXd::Unit(n, i), 1.0});
      domain_.push_back({-VectorXd::Unit(n, i), 1.0});
    }
    domain_.push_back({-program.mirror() / program.mirror().norm(), 0.0});
    enqueue(program.sides_at(1e-3 * program.mirror() / program.mirror().norm()));
    while (!queue_.empty()) {
      if (regions_.size() > kMostRegions) {
        throw TooLarge{};
      }
      const Sides sides = queue_.front();
      queue_.pop_front();
      explore(sides);
      work_.tell(regions_.size(), 0);
    }
    join_borders();
  }

  const std::vector<Region>& regions() const { return regions_; }
  const std::vector<Piece>& pieces() const { return pieces_; }
  const std::vector<Border>& borders() const { return borders_; }
  const std::vector<HalfSpace>& domain() const { return domain_; }

 private:
  struct Crossing {
    std::size_t from;
    Sides to;
    HalfSpace plane;
    std::vector<VectorXd> points;
  };

  void enqueue(const Sides& sides) {
    if (known_.emplace(sides, SIZE_MAX).second) {
      queue_.push_back(sides);
    }
  }

  std::size_t piece_index(const Piece& piece) {
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      const Piece& other = pieces_.at(i);
      if (other.side == piece.side && (piece.side != 0 || ((other.slope - piece.slope).cwiseAbs().maxCoeff() < 1e-9 &&
                                                           std::abs(other.constant - piece.constant) < 1e-9))) {
        return i;
      }
    }
    pieces_.push_back(piece);
    return pieces_.size() - 1;
  }

  void explore(const Sides& sides) {
    auto [rows, piece] = program_.region_of(sides);
    const std::size_t own = rows.size();
    rows.insert(rows.end(), domain_.begin(), domain_.end());
    Polytope polytope(static_cast<std::size_t>(program_.size()), work_.allowance());
    for (const HalfSpace& row : rows) {
      polytope.add(row);
    }
    if (polytope.radius() < 1e-9) {
      return;
    }
    Region region;
    const std::size_t index = regions_.size();
    for (Index i = 0; i < program_.size(); ++i) {
      for (const double sign : {1.0, -1.0}) {
        VectorXd corner;
        polytope.maximise(sign * VectorXd::Unit(program_.size(), i), 1e300, &corner);
        region.corners.push_back(corner);
      }
    }
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (i >= own ? false : !polytope.is_facet(i)) {
        continue;
      }
      region.rows.push_back(rows.at(i));
      if (i >= own) {
        continue;
      }
      VectorXd corner;
      polytope.maximise(-rows.at(i).a, 1e300, &corner);
      region.corners.push_back(corner);
      VectorXd centre;
      polytope.radius(&centre, i);
      const VectorXd across = centre + kNudge * rows.at(i).a;
      if (across.cwiseAbs().maxCoeff() > 1.0 || program_.mirror().dot(across) < 0.0) {
        continue;
      }
      const Sides next = program_.sides_at(across);
      enqueue(next);
      crossings_.push_back({index, next, rows.at(i), {centre}});
    }
    region.piece = piece_index(piece);
    known_.at(sides) = index;
    regions_.push_back(std::move(region));
  }

  void join_borders() {
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

  Parametric& program_;
  const Undertaking& work_;
  std::vector<HalfSpace> domain_;
  std::map<Sides, std::size_t> known_;
  std::deque<Sides> queue_;
  std::vector<Region> regions_;
  std::vector<Piece> pieces_;
  std::vector<Crossing> crossings_;
  std::vector<Border> borders_;
};

/// The search tree over the regions.
class Tree {
 public:
  Tree(const Regions& all, const Parametric& program, const Undertaking& work, SetpointRows& out)
      : all_(all), program_(program), work_(work), out_(out) {
    std::vector<std::size_t> regions(all.regions().size());
    for (std::size_t i = 0; i < regions.size(); ++i) {
      regions.at(i) = i;
    }
    std::vector<std::size_t> borders(all.borders().size());
    for (std::size_t i = 0; i < borders.size(); ++i) {
      borders.at(i) = i;
    }
    const std::vector<double> mirror = row({program.mirror() / program.mirror().norm(), 0.0});
    std::copy(mirror.begin() + 1, mirror.end(), out.mirror.begin());
    std::vector<HalfSpace> cell;
    pack(build(cell, regions, borders, 1), 1);
    out.planes.push_back(0.0);
  }

 private:
  static constexpr std::uint16_t kLeaf = mpc::SetpointTree<double>::kLeaf;
  /// One plane of the search, before planes are put together.
  struct Binary {
    std::vector<double> plane;
    std::array<std::uint16_t, 2> child{};
  };

  /// How the planes below one are put together so that the longest path has the fewest nodes.
  struct Plan {
    std::vector<std::uint16_t> planes;  ///< of the node: a plane, then planes right below one of them
    std::uint32_t depth = 0;
    std::size_t nodes = 0;
  };

  const Plan& plan(std::uint16_t root) {
    const auto known = plans_.find(root);
    if (known != plans_.end()) {
      return known->second;
    }
    Plan best;
    const auto consider = [&](std::vector<std::uint16_t> planes) {
      Plan tried{std::move(planes), 0, 1};
      for (const std::uint16_t plane : tried.planes) {
        for (const std::uint16_t child : binary_.at(plane).child) {
          if (child < kLeaf && std::find(tried.planes.begin(), tried.planes.end(), child) == tried.planes.end()) {
            tried.depth = std::max(tried.depth, plan(child).depth);
            tried.nodes += plan(child).nodes;
          }
        }
      }
      ++tried.depth;
      if (best.planes.empty() || std::pair(tried.depth, tried.nodes) < std::pair(best.depth, best.nodes)) {
        best = std::move(tried);
      }
    };
    const std::array<std::uint16_t, 2> child = binary_.at(root).child;
    consider({root});
    for (const std::uint16_t second : child) {
      if (second < kLeaf) {
        consider({root, second});
        for (const std::uint16_t third : {binary_.at(second).child[0], binary_.at(second).child[1]}) {
          if (third < kLeaf) {
            consider({root, second, third});
          }
        }
      }
    }
    if (child[0] < kLeaf && child[1] < kLeaf) {
      consider({root, child[0], child[1]});
    }
    return plans_[root] = best;
  }

  /// Puts the planes of `root`'s plan into one node of the table, and all below into others. @returns its number.
  std::uint16_t pack(std::uint16_t root, std::uint32_t depth) {
    if (root >= kLeaf && depth > 1) {
      return root;
    }
    if (out_.nodes.size() >= mpc::kMaxSetpointNodes) {
      throw TooLarge{};
    }
    out_.depth = std::max(out_.depth, depth);
    const std::size_t node = out_.nodes.size();
    out_.nodes.push_back({});
    const std::vector<std::uint16_t> planes = root < kLeaf ? plan(root).planes : std::vector<std::uint16_t>{};
    for (std::size_t i = 0; i < mpc::kPlaneNumbers; ++i) {
      for (std::size_t p = 0; p < mpc::kNodePlanes; ++p) {
        out_.planes.push_back(p < planes.size() ? binary_.at(planes.at(p)).plane.at(i) : 0.0);
      }
    }
    std::map<std::uint16_t, std::uint16_t> below;
    for (std::size_t index = 0; index < out_.nodes.front().child.size(); ++index) {
      std::uint16_t at = root;
      for (std::size_t p = 0; p < planes.size(); ++p) {  // a plane stands before those below it
        at = planes.at(p) == at ? binary_.at(at).child.at(index >> p & 1U) : at;
      }
      if (!below.contains(at)) {
        below[at] = pack(at, depth + 1);
      }
      out_.nodes.at(node).child.at(index) = below.at(at);
    }
    return static_cast<std::uint16_t>(node);
  }

  std::uint16_t build(std::vector<HalfSpace>& cell, const std::vector<std::size_t>& regions,
                      const std::vector<std::size_t>& borders, std::uint32_t depth) {
    std::size_t piece = 0;
    if (is_leaf(cell, regions, piece)) {
      return static_cast<std::uint16_t>(kLeaf + put_law(piece));
    }
    if (binary_.size() >= kMostPlanes || depth > kDeepestTree) {
      throw TooLarge{};
    }
    HalfSpace plane;
    if (!borders.empty()) {
      plane = best_plane(regions, borders);
    } else if (!parting_plane(cell, regions, plane)) {
      return static_cast<std::uint16_t>(kLeaf + put_law(all_.regions().at(only_real_one(cell, regions)).piece));
    }
    work_.tell(all_.regions().size(), binary_.size());
    const auto node = static_cast<std::uint16_t>(binary_.size());
    binary_.push_back({row(plane), {}});
    out_.borders = std::max<std::size_t>(out_.borders, depth);
    for (const int side : {0, 1}) {
      const HalfSpace half = side == 0 ? plane : HalfSpace{-plane.a, -plane.b};
      std::vector<std::size_t> kept;
      for (const std::size_t region : regions) {
        if (meets(region, cell, half)) {
          kept.push_back(region);
        }
      }
      std::set<std::size_t> here(kept.begin(), kept.end());
      std::vector<std::size_t> kept_borders;
      for (const std::size_t border : borders) {
        const Border& b = all_.borders().at(border);
        const bool same_plane = (b.plane.a - plane.a).norm() < 1e-7 || (b.plane.a + plane.a).norm() < 1e-7;
        if (here.contains(b.first) && here.contains(b.second) &&
            !(same_plane && std::abs(std::abs(b.plane.b) - std::abs(plane.b)) < 1e-7)) {
          kept_borders.push_back(border);
        }
      }
      cell.push_back(half);
      const std::uint16_t child = build(cell, kept, kept_borders, depth + 1);
      cell.pop_back();
      binary_.at(node).child.at(static_cast<std::size_t>(side)) = child;
    }
    return node;
  }

  /// Whether all regions in the cell follow from one law once it is clipped.
  bool is_leaf(const std::vector<HalfSpace>& cell, const std::vector<std::size_t>& regions, std::size_t& piece) const {
    const std::vector<Piece>& pieces = all_.pieces();
    bool has_affine = false;
    std::set<std::size_t> found;
    for (const std::size_t region : regions) {
      const std::size_t p = all_.regions().at(region).piece;
      found.insert(p);
      if (pieces.at(p).side == 0) {
        if (has_affine && piece != p) {
          return false;
        }
        has_affine = true;
        piece = p;
      }
    }
    if (found.size() <= 1) {
      piece = found.empty() ? all_.regions().front().piece : *found.begin();
      return true;
    }
    if (!has_affine) {
      return false;
    }
    for (const std::size_t region : regions) {
      const int side = pieces.at(all_.regions().at(region).piece).side;
      if (side != 0 && !saturates(region, cell, pieces.at(piece), side)) {
        return false;
      }
    }
    return true;
  }

  /// Whether the affine piece is beyond the limit of `side` all over region and cell.
  bool saturates(std::size_t region, const std::vector<HalfSpace>& cell, const Piece& affine, int side) const {
    const double bound = program_.limit() - side * affine.constant;  // side * slope s >= bound wanted
    for (const VectorXd& corner : all_.regions().at(region).corners) {
      bool inside = true;
      for (const HalfSpace& half : cell) {
        inside = inside && half.a.dot(corner) <= half.b - 1e-9;
      }
      if (inside && side * affine.slope.dot(corner) < bound - 1e-7) {
        return false;  // a witness: no program needed
      }
    }
    Polytope polytope(static_cast<std::size_t>(program_.size()), work_.allowance());
    fill(polytope, region, cell);
    return -polytope.maximise(-side * affine.slope, -bound) >= bound - 1e-9;
  }

  void fill(Polytope& polytope, std::size_t region, const std::vector<HalfSpace>& cell) const {
    for (const HalfSpace& row : all_.regions().at(region).rows) {
      polytope.add(row);
    }
    for (const HalfSpace& row : cell) {
      polytope.add(row);
    }
  }

  bool meets(std::size_t region, const std::vector<HalfSpace>& cell, const HalfSpace& half) const {
    Polytope polytope(static_cast<std::size_t>(program_.size()), work_.allowance());
    fill(polytope, region, cell);
    polytope.add(half);
    return polytope.radius() > kThin;
  }

  /// Regions without a common facet in the cell: the facet of one of them that leaves the fewest on its fuller side.
  /// @returns false when none parts them.
  bool parting_plane(const std::vector<HalfSpace>& cell, const std::vector<std::size_t>& regions,
                     HalfSpace& best) const {
    std::size_t fewest = regions.size();
    for (const std::size_t owner : regions) {
      for (const HalfSpace& row : all_.regions().at(owner).rows) {
        std::size_t below = 0;
        std::size_t above = 0;
        for (const std::size_t region : regions) {
          below += meets(region, cell, row) ? 1U : 0U;
          above += meets(region, cell, {-row.a, -row.b}) ? 1U : 0U;
        }
        if (std::max(below, above) < fewest) {
          fewest = std::max(below, above);
          best = row;
        }
      }
    }
    return fewest < regions.size();
  }

  /// Regions that nothing parts overlap by their rounding. @returns the one that is more than that.
  std::size_t only_real_one(const std::vector<HalfSpace>& cell, const std::vector<std::size_t>& regions) const {
    std::size_t real = regions.front();
    double largest = 0.0;
    double second = 0.0;
    for (const std::size_t region : regions) {
      Polytope polytope(static_cast<std::size_t>(program_.size()), work_.allowance());
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

  /// The plane of a border that leaves the fewest borders on its fuller side.
  HalfSpace best_plane(const std::vector<std::size_t>& regions, const std::vector<std::size_t>& borders) const {
    std::vector<HalfSpace> candidates;
    for (const std::size_t border : borders) {
      const HalfSpace& plane = all_.borders().at(border).plane;
      work_.allowance().compare(candidates.size());
      const bool known = std::any_of(candidates.begin(), candidates.end(), [&plane](const HalfSpace& other) {
        return ((other.a - plane.a).norm() < 1e-7 && std::abs(other.b - plane.b) < 1e-7) ||
               ((other.a + plane.a).norm() < 1e-7 && std::abs(other.b + plane.b) < 1e-7);
      });
      if (!known) {
        candidates.push_back(plane);
      }
    }
    double best_score = 1e300;
    std::size_t best = 0;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      const HalfSpace& plane = candidates.at(c);
      double low = 0;
      double high = 0;
      for (const std::size_t border : borders) {
        const auto [below, above] = sides_of(plane, all_.borders().at(border).points);
        low += below ? 1 : 0;
        high += above ? 1 : 0;
      }
      double low_regions = 0;
      double high_regions = 0;
      for (const std::size_t region : regions) {
        const auto [below, above] = sides_of(plane, all_.regions().at(region).corners);
        low_regions += below ? 1 : 0;
        high_regions += above ? 1 : 0;
      }
      const double score = std::max(low, high) + 0.3 * (low + high) + 0.05 * std::max(low_regions, high_regions) +
                           (std::min(low_regions, high_regions) < 1 ? 1e6 : 0.0);
      if (score < best_score) {
        best_score = score;
        best = c;
      }
    }
    return candidates.at(best);
  }
  std::pair<bool, bool> sides_of(const HalfSpace& plane, const std::vector<VectorXd>& points) const {
    work_.allowance().compare(points.size());
    bool below = false;
    bool above = false;
    for (const VectorXd& point : points) {
      const double at = plane.a.dot(point) - plane.b;
      below = below || at < -1e-7;
      above = above || at > 1e-7;
    }
    return {below, above};
  }

  std::size_t slot(Index j) const { return static_cast<std::size_t>(program_.slots().at(static_cast<std::size_t>(j))); }

  /// A plane of the table: positive beyond the half-space.
  std::vector<double> row(const HalfSpace& plane) const {
    std::vector<double> out(mpc::kPlaneNumbers, 0.0);
    out.at(0) = -plane.b;
    for (Index j = 0; j < program_.size(); ++j) {
      out.at(1 + slot(j)) = plane.a(j) / program_.box().at(slot(j));
    }
    return out;
  }
  std::size_t put_law(std::size_t piece) {
    const auto known = laws_.find(piece);
    if (known != laws_.end()) {
      return known->second;
    }
    const Piece& p = all_.pieces().at(piece);
    std::array<double, mpc::kLawNumbers> numbers{};
    numbers.back() = p.side != 0 ? p.side * program_.limit() : p.constant;
    for (Index j = 0; j < program_.size() && p.side == 0; ++j) {
      numbers.at(slot(j)) = p.slope(j) / program_.box().at(slot(j));
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

  const Regions& all_;
  const Parametric& program_;
  const Undertaking& work_;
  SetpointRows& out_;
  std::vector<Binary> binary_;
  std::map<std::uint16_t, Plan> plans_;
  std::map<std::size_t, std::size_t> laws_;
};

}  // namespace

SetpointRows make_setpoint_law(const AxisProblem& problem, const SetpointBox& box, Allowance allowance,
                               const SetpointProgress& progress) {
  SetpointRows out;
  if (problem.u_min != -problem.u_max || static_cast<double>(problem.u_max) <= box.at(5)) {
    return out;
  }
  Parametric program(problem, box);
  const Undertaking work(allowance, progress);
  try {
    const Regions regions(program, work);
    const Tree tree(regions, program, work, out);
    out.regions = regions.regions().size();
    out.pieces = static_cast<std::size_t>(std::count_if(regions.pieces().begin(), regions.pieces().end(),
                                                        [](const Piece& piece) { return piece.side == 0; }));
  } catch (const TooLarge&) {
    out = {};
    out.too_large = true;
  }
  out.box = box;
  out.programs = allowance.programs_spent();
  out.comparisons = allowance.comparisons_spent();
  return out;
}

void attach(const SetpointRows& rows, mpc::GainTable<double>& table) {
  table.setpoint.nodes = rows.nodes;
  table.setpoint.planes = rows.planes;
  table.setpoint.laws = rows.laws;
  table.setpoint.box = rows.box;
  table.setpoint.mirror = rows.mirror;
  table.setpoint.depth = rows.depth;
}

}  // namespace m100::tools::gains
