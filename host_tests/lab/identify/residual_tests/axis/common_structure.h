// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "host_tests/lab/identify/axis_problem.h"
#include "host_tests/lab/identify/residual_tests/axis/weak_effect.h"

namespace m100::lab::identify {

/// Gives a place to effects that both parts together show with certainty (weak_effect()), but that the training part
/// alone did not choose: in the place of the effect that it imitates, or beside the others. Both parts must confirm it,
/// each predicted by a fit to the other. So the names depend neither on where the log is cut nor on which part trains.
/// Changes nothing if the parts are of two logs, or if the validation part is too short or too calm for a fit.
/// Cost: that of weak_effect() and a few fits for each effect placed.
/// @returns the certain effect that found no place; empty: none
std::optional<WeakEffect> settle(const AxisProblem& problem, Selection& selection);

}  // namespace m100::lab::identify
