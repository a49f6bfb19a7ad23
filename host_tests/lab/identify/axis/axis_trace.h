// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host_tests/lab/identify/axis/axis_family.h"
#include "host_tests/lab/identify/axis/free_run.h"

namespace m100::lab::identify {

/// An effect that is certainly there and explains too little to be named.
struct AxisTrace {
  std::string name;
  /// Twice the logarithm, less Schwarz's price of its parameters and twice the logarithm of how many beginnings of
  /// effects were asked.
  double likelihood_ratio = 0.0;
};

/// The likeliest of all effects that a model does not have, each fitted to whitened free runs with all that the model
/// has; nothing where none is certain or none means something by its size. Selection asks for a better prediction of
/// blocks, in which strong slow air hides what a likelihood ratio sees: what it does not take may be there all the
/// same, and no clean bill is due. Each effect is begun at several sizes, and fitted where a step toward it promises
/// something; where the model jumps at its dead zone's edge, beside the zone without the jump as well. Cost: a
/// simulation for each beginning, a few fits.
/// @param readings  of the log: as it is first; then with the stick otherwise between its rows, where that is not
///   known. What is certain is so in each of them, and rows after a stick that moved count less. Precondition: at least
///   one.
/// @param data  of the first reading
std::optional<AxisTrace> trace_of(std::vector<FreeRun> readings, const AxisData& data, const AxisFamily& family,
                                  const Fit& fit);

}  // namespace m100::lab::identify
