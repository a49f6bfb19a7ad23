// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "firmware/mpc/gain_table.h"
#include "host_tests/tools/gains/axis_model.h"

namespace m100::tools::gains {

/// The rows of one axis' set-point law, owned, and how they came about.
struct SetpointRows {
  std::vector<double> planes;
  std::vector<double> laws;
  std::vector<mpc::SetpointNode> nodes;
  std::array<double, 6> box{};
  std::uint32_t depth = 0;
  std::size_t regions = 0;  ///< critical regions in the half of the box that is not mirrored
  std::size_t pieces = 0;   ///< affine functions among them
};

/// Largest parameters the law is made for: position error [m], velocity [m/s], tilt off its target [rad], tilt rate
/// [rad/s], previous input off the steady input [rad], steady input [rad].
inline constexpr std::array<double, 6> kSetpointBox{4.0, 3.0, 0.5, 2.5, 0.6, 0.31};

/// The explicit optimum of one axis for a constant reference. The critical regions (active sets) are found by walking
/// over every facet, each facet decided by a linear program (GLPK, in rational arithmetic where floating point leaves
/// it open); the tree is split along facets until the regions that meet a leaf, again by linear programs, all follow
/// from one clipped affine law. Empty where the limits are not symmetric. Takes seconds.
SetpointRows make_setpoint_law(const AxisProblem& problem);

/// Lets the table use the law; `rows` must outlive it.
void attach(const SetpointRows& rows, mpc::GainTable<double>& table);

}  // namespace m100::tools::gains
