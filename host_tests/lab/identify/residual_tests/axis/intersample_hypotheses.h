// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host_tests/lab/identify/model/axis/axis_blocks.h"
#include "host_tests/lab/identify/model/axis/axis_family.h"
#include "host_tests/lab/identify/model/axis/free_run.h"
#include "host_tests/lab/identify/request.h"

namespace m100::lab::identify {

/// The readings of a log: interpolated, and, where the rows of its stick are further apart than samples, also with the
/// stick held at its last row and with its next row used early. The stick between rows is unknown, so only a result
/// that all three readings confirm is certain.
struct IntersampleHypotheses {
  std::vector<AxisData> held;  ///< data of the second and third run; empty where the rows are not slow
  std::vector<FreeRun> runs;
};

/// The data must outlive the readings.
IntersampleHypotheses intersample_hypotheses(const AxisData& data, const std::vector<Range>& ranges);

/// Weighs the innovations of all readings by the uncertainty that slow rows of the stick cause. Each step between two
/// rows may have happened at any moment of the row, which adds a variance to the rows after it; the share of this
/// variance beside that of the air is estimated by maximum likelihood. Does nothing where the rows are not slow.
/// Precondition: the first reading is of `data`.
void weight_by_input_uncertainty(std::span<FreeRun> hypotheses, const AxisData& data, const model::StickAxis& model);

/// All parameters of a structure as knobs_of(), with the delay free down to one row below zero: a row shows the stick
/// since the row before, so a response without delay may begin up to a row early. A larger shift is left to clock_of().
std::vector<FreeParameter> free_parameters_within_row(const AxisFamily& family, const Fit& fit);

/// Smallest likelihood ratio of an effect of the fit over all readings of a log with slow rows, with weighed
/// innovations; infinity where the rows are not slow, or where the effect cannot be removed. A straight line between
/// two rows makes a stick that jumped begin early and end late. A dead zone compensates this, but with the held
/// readings it disappears.
double min_ratio_over_hypotheses(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                                 const Fit& fit, const std::string& effect);

}  // namespace m100::lab::identify
