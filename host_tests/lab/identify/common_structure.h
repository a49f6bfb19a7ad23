// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "host_tests/lab/identify/axis_problem.h"
#include "host_tests/lab/identify/residual_tests/axis/weak_effect.h"

namespace m100::lab::identify {

/// Settles by both parts together what the training part alone leaves open, so that the names depend neither on where
/// the log is cut nor on which part trains. Each part is predicted by a fit to the other. An effect is exchanged with
/// another one that predicts better or, where both predict alike, is likelier. One that the likelihood shows with
/// certainty (weak_effect()) is added if it predicts better. A trim is named by the evidence of both parts.
/// Changes nothing if the parts are of two logs, or if the validation part is too short or too calm for a fit.
/// Cost: that of weak_effect(), and a fit for each effect and each other effect in its place.
/// @returns the certain effect that found no place; empty: none
std::optional<WeakEffect> settle(const AxisProblem& problem, Selection& selection);

}  // namespace m100::lab::identify
