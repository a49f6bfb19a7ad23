// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "host_tests/lab/identify/data/axis_signals.h"
#include "host_tests/lab/identify/residual_tests/predictable_share.h"

namespace m100::lab::identify {

/// Regressors for the residual of this axis, over the samples [begin, end) of the log: lags, powers and products of
/// the sticks, time, and every extra channel. Rates and velocities are left out, because they move with the residual
/// itself. Every column is averaged over the rows of `rows`, to save memory.
/// @param rows  thinning of the stretch; its samples are counted from `begin`
std::vector<RegressorGroup> axis_regressors(const logs::FlightLog& log, const AxisSignals& signals, std::size_t begin,
                                            std::size_t end, const Thinned& rows);
/// Activity of the axis' stick (sizes of its value and slope, lagged), which may explain the residual's size.
std::vector<RegressorGroup> axis_activity(const AxisSignals& signals, std::size_t begin, std::size_t end,
                                          const Thinned& rows);

}  // namespace m100::lab::identify
