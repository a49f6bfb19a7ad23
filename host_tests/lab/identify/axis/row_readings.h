// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host_tests/lab/identify/axis/axis_blocks.h"
#include "host_tests/lab/identify/axis/axis_family.h"
#include "host_tests/lab/identify/axis/free_run.h"
#include "host_tests/lab/identify/request.h"

namespace m100::lab::identify {

/// A log as it was read, and where its stick's rows are further apart than samples also with the stick held at its last
/// and at its next row all the way: what it did in between nobody knows, and what is certain is so in all three.
struct RowReadings {
  std::vector<AxisData> held;  ///< what the later runs are of; empty where the rows leave nothing open
  std::vector<FreeRun> runs;
};

/// The data must outlive the readings.
RowReadings readings_of(const AxisData& data, const std::vector<Range>& ranges);

/// Weighs the innovations of all readings by what slow rows of the stick leave open: each way between two rows may have
/// been made at any moment of the row, which gives the rows after it a variance; how much of it there is beside the
/// air's is estimated by maximum likelihood. Nothing where the rows are not slow. Precondition: the first is of `data`.
void weigh_by_what_is_known(std::span<FreeRun> readings, const AxisData& data, const model::StickAxis& model);

/// Everything that a structure has, as knobs_of(), and the delay free down to a row below nought: a row shows what the
/// stick was since the row before, so a response without delay may begin up to a row early. More than that is for the
/// clock to say.
std::vector<Knob> knobs_within_a_row(const AxisFamily& family, const Fit& fit);

/// Likelihood ratio of an effect that a fit has under that reading of a log with slow rows which speaks least for it,
/// the innovations weighed by what is known of them; infinity where the rows are not slow, or where the effect cannot
/// be taken out. A straight line between two rows lets a stick that jumped begin early and end late: a dead zone gives
/// that back, and under a stick that was held there is none.
double ratio_between_rows(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                          const Fit& fit, const std::string& effect);

}  // namespace m100::lab::identify
