// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "firmware/mpc/gain_table.h"
#include "host_tests/lab/gains/axis_model.h"
#include "host_tests/lab/gains/linear_program.h"

namespace m100::lab::gains {

/// The rows of one axis' set-point law, owned, and how they came about.
struct SetpointRows {
  std::vector<double> planes;
  std::vector<double> laws;
  std::vector<mpc::SetpointNode> nodes;
  std::array<double, mpc::kSetpointStates> box{};
  std::array<double, mpc::kPlaneNumbers - 1> mirror{};
  std::uint32_t depth = 0;
  std::size_t regions = 0;                      ///< critical regions in the half of the box that is not mirrored
  std::size_t pieces = 0;                       ///< affine functions among them
  std::size_t borders = 0;                      ///< planes on the longest path
  bool too_large = false;                       ///< the law has no table: everything above is empty
  std::uint64_t programs = 0, comparisons = 0;  ///< what the construction cost
};

/// Largest parameters the law is made for: position error [m], velocity [m/s], tilt off its target [rad], tilt rate
/// [rad/s], previous input off the steady input [rad], steady input [rad]; then the rests that rounding leaves.
using SetpointBox = std::array<double, mpc::kSetpointStates>;
inline constexpr SetpointBox kSetpointBox{6.0, 4.0, 0.5, 2.0, 0.75, 0.31, 2e-5, 2e-5};

/// The explicit optimum of one axis for a constant reference. The critical regions (active sets) are found by walking
/// over every facet, each facet decided by a linear program (GLPK, in rational arithmetic where floating point leaves
/// it open); the tree is split along facets until the regions that meet a leaf, again by linear programs, all follow
/// from one clipped affine law. Every length of the box is positive. Empty where the limits are not symmetric, or not
/// above the largest steady input. Takes seconds; too_large when the allowance is spent, or the table file would not
/// hold it.
using SetpointProgress = std::function<void(std::size_t regions, std::size_t planes, double allowance_spent)>;
SetpointRows make_setpoint_law(const AxisProblem& problem, const SetpointBox& box = kSetpointBox,
                               Allowance allowance = Allowance(), const SetpointProgress& progress = {});

/// Lets the table use the law; `rows` is what make_setpoint_law() gave for the same problem, and must outlive it.
void attach(const SetpointRows& rows, mpc::GainTable<double>& table);

}  // namespace m100::lab::gains
