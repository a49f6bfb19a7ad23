// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/setpoint/setpoint_packing.h"

#include <algorithm>
#include <map>
#include <utility>

#include "firmware/mpc/table_file.h"

namespace m100::lab::gains {
namespace {

/// The best packing of one plane and the planes below it: the longest path has the fewest nodes.
struct Plan {
  std::vector<std::uint16_t> planes;  ///< planes of the node: the first, then planes directly below one of them
  std::uint32_t depth = 0;
  std::size_t nodes = 0;
};

class Packing {
 public:
  Packing(const std::vector<SplitPlane>& split, SetpointRows& out) : split_(split), out_(out) {}

  /// Packs the tree from `root` down. @returns the number of its first node, or `root` if it is a leaf below the first
  /// node
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
    append(planes);
    std::map<std::uint16_t, std::uint16_t> below;
    for (std::size_t index = 0; index < out_.nodes.front().child.size(); ++index) {
      std::uint16_t at = root;
      for (std::size_t p = 0; p < planes.size(); ++p) {  // a plane precedes those below it
        at = planes.at(p) == at ? split_.at(at).child.at(index >> p & 1U) : at;
      }
      if (!below.contains(at)) {
        below[at] = pack(at, depth + 1);
      }
      out_.nodes.at(node).child.at(index) = below.at(at);
    }
    return static_cast<std::uint16_t>(node);
  }

 private:
  /// Appends the planes of one node, number by number; missing planes are zero.
  void append(const std::vector<std::uint16_t>& planes) {
    for (std::size_t i = 0; i < mpc::kPlaneNumbers; ++i) {
      for (std::size_t p = 0; p < mpc::kNodePlanes; ++p) {
        out_.planes.push_back(p < planes.size() ? split_.at(planes.at(p)).plane.at(i) : 0.0);
      }
    }
  }

  const Plan& plan(std::uint16_t root) {
    const auto known = plans_.find(root);
    if (known != plans_.end()) {
      return known->second;
    }
    Plan best;
    const auto consider = [&](std::vector<std::uint16_t> planes) {
      Plan tried = plan_with(std::move(planes));
      if (best.planes.empty() || std::pair(tried.depth, tried.nodes) < std::pair(best.depth, best.nodes)) {
        best = std::move(tried);
      }
    };
    const std::array<std::uint16_t, 2> child = split_.at(root).child;
    consider({root});
    for (const std::uint16_t second : child) {
      if (second >= kLeaf) {
        continue;
      }
      consider({root, second});
      for (const std::uint16_t third : split_.at(second).child) {
        if (third < kLeaf) {
          consider({root, second, third});
        }
      }
    }
    if (child[0] < kLeaf && child[1] < kLeaf) {
      consider({root, child[0], child[1]});
    }
    return plans_[root] = best;
  }

  /// The plan that puts these planes into one node, with its depth and its number of nodes.
  Plan plan_with(std::vector<std::uint16_t> planes) {
    Plan out{std::move(planes), 0, 1};
    for (const std::uint16_t plane : out.planes) {
      for (const std::uint16_t child : split_.at(plane).child) {
        if (child < kLeaf && std::find(out.planes.begin(), out.planes.end(), child) == out.planes.end()) {
          out.depth = std::max(out.depth, plan(child).depth);
          out.nodes += plan(child).nodes;
        }
      }
    }
    ++out.depth;
    return out;
  }

  const std::vector<SplitPlane>& split_;
  SetpointRows& out_;
  std::map<std::uint16_t, Plan> plans_;
};

}  // namespace

void pack_planes(const std::vector<SplitPlane>& split, SetpointRows& out) {
  Packing(split, out).pack(split.empty() ? kLeaf : std::uint16_t{0}, 1);
  out.planes.push_back(0.0);
}

}  // namespace m100::lab::gains
