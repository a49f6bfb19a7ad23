// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "firmware/mpc/gain_table.h"
#include "host_tests/lab/gains/axis_model.h"
#include "host_tests/lab/gains/setpoint/linear_program.h"

namespace m100::lab::gains {

/// The owned rows of one axis' set-point law, and statistics of their construction.
struct SetpointRows {
  std::vector<double> planes;
  std::vector<double> laws;
  std::vector<mpc::SetpointNode> nodes;
  std::array<double, mpc::kSetpointStates> box{};
  std::array<double, mpc::kPlaneNumbers - 1> mirror{};
  std::uint32_t depth = 0;
  std::size_t regions = 0;                      ///< critical regions in the unmirrored half of the box
  std::size_t pieces = 0;                       ///< affine functions among them
  std::size_t borders = 0;                      ///< planes on the longest path
  bool too_large = false;                       ///< the law has no table: all members above but `box` are empty
  std::uint64_t programs = 0, comparisons = 0;  ///< cost of the construction
};

/// Largest parameters for which the law is made: position error [m], velocity [m/s], tilt minus its target [rad], tilt
/// rate [rad/s], previous minus steady input [rad], steady input [rad]; then two residuals from rounding.
using SetpointBox = std::array<double, mpc::kSetpointStates>;
inline constexpr SetpointBox kSetpointBox{6.0, 4.0, 0.5, 2.0, 0.75, 0.31, 2e-5, 2e-5};

/// Receives the numbers of regions and planes so far, and the spent share of the budget.
using SetpointProgress = std::function<void(std::size_t regions, std::size_t planes, double allowance_spent)>;

/// Computes the explicit optimum of one axis for a constant reference: a tree of planes whose leaves are clipped affine
/// laws. Precondition: every length of the box is positive. The result is empty if the limits are not symmetric or not
/// above the largest steady input. It is too_large if the budget is spent or the table file cannot hold the law.
SetpointRows make_setpoint_law(const AxisQp& problem, const SetpointBox& box = kSetpointBox,
                               ComputeBudget budget = ComputeBudget(), const SetpointProgress& progress = {});

/// Lets the table use the law. `rows` come from make_setpoint_law() for the same problem and must outlive the table.
void attach(const SetpointRows& rows, mpc::GainTable<double>& table);

}  // namespace m100::lab::gains
