// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/identify/axis_problem.h"
#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/identify/remainder_channels.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::identify {

// What the final model leaves, drawn against every channel of the log: an effect without a name shows where it acts.

/// The inputs of a result's directions of translation, from the series of its figures.
std::vector<RemainderInput> remainder_of(const IdentifyResult& translation);

/// The remainder r = (1 + slope_s d/dt + curvature_s2 d^2/dt^2) error is the command that the model lacks: local in
/// time, so that its cause is what the channels show at the same moment. The derivatives are those of the least-squares
/// parabola through seven rows (Savitzky and Golay, Anal. Chem. 36, 1964). For each channel x two curves are fitted,
///   r = f(x)        something is added to the command, e.g. a force
///   r = g(x) c      the gain of the command c changes (varying coefficient, Hastie and Tibshirani, JRSS B 55, 1993)
/// with f, g cubic regression splines of few knots under a ridge penalty that cross-validation chooses. Each is judged
/// by the share of r that it predicts in pieces of the log that its fit has not seen. Bands: 95 %, over blocks of 2.5
/// s.
/// @returns all curves, the largest share first; the first six have points. Empty without enough rows.
/// Cost: linear in the rows up to 3000, times the channels.
std::vector<RemainderCurve> remainder_curves(const std::vector<RemainderInput>& inputs, const logs::FlightLog& log);

/// Draws the remainder of a stick axis: free runs of the fit over all ranges of the training log. If a curve over the
/// axis' own stick or the model's response predicts more than a quarter of it in the pieces that its fit has not seen,
/// and clearly more than chance does, this is unexplained.
void draw_remainder(const AxisProblem& problem, const Fit& fit, const logs::FlightLog& log, SideFindings& out);

}  // namespace m100::lab::identify
