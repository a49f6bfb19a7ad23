// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "host_tests/lab/identify/model/axis/axis_family.h"
#include "host_tests/lab/identify/model/axis/free_run.h"
#include "host_tests/lab/identify/output/result.h"

namespace m100::lab::identify {

/// The free parameters of a fit, to be fitted again to whitened free runs; without the gain of the other stick, and
/// without the width of a dead zone with a jump, on which the error does not depend smoothly.
std::vector<FreeParameter> free_parameters_of(const AxisFamily& family, const Fit& fit);

/// Likelihood ratio from which on a change is named.
inline constexpr double kCertainChange = 30.0;
/// From this likelihood ratio on, "nothing missing" is ruled out. In 480 healthy logs no change reached it.
inline constexpr double kLikelyChange = 24.0;
/// Below this likelihood ratio a change is chance: over all times and five parameters, 1 healthy log of 100 exceeds it.
inline constexpr double kChanceChange = 16.0;

/// A smaller change of a delay is no effect, whatever its statistics: the lag of motors and what a loop feeds back
/// shift the delay of healthy logs by up to 12 ms, with likelihood ratios of 50 and more.
inline constexpr double kMinDelayChange_s = 0.015;

/// A change of one parameter in flight: gain, frequency, damping, transport_delay, dead_zone or trim_offset.
struct ChangePoint {
  bool found = false;
  bool likely = false;  ///< not found, but likely and large enough for a doubt; the members below are set, too
  Change change;
  double score = 0.0;            ///< of the model with the change, refitted (see WhitenedFit)
  std::size_t numbers = 0;       ///< of free parameters beside the change
  FreeParameter free_parameter;  ///< what changed
  model::StickAxis before, after;
};

/// Scans the free run of a fit for a parameter that takes another value (change_scan.h), then refits every candidate at
/// its own best time. The best one names the change; others within kNameMargin of it are its rivals. The likelihood
/// ratio against no change must be at least kCertainChange, and the change large enough to matter. The ratio is
/// computed with the residual variance of the noisier side of the change.
/// Precondition: the fit is of `family`. Cost: one scan for each candidate, some 1000 simulations where one is found.
ChangePoint change_point(const FreeRun& run, const AxisFamily& family, const Fit& fit);

/// From which likelihood ratio on one name is preferred to another.
inline constexpr double kNameMargin = 6.0;

/// The fit's structure, refitted with constant parameters. Its score is compared with ChangePoint::score.
WhitenedFit unchanged_fit(const FreeRun& run, const AxisFamily& family, const Fit& fit);

}  // namespace m100::lab::identify
