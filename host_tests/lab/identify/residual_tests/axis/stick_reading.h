// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host_tests/lab/identify/model/axis/axis_family.h"
#include "host_tests/lab/identify/request.h"

namespace m100::lab::identify {

// The vehicle may have received another stick than the logged one.

/// Whether the stick was logged more slowly than its column says (it holds its values), or in coarser steps: a line
/// through the new values, or between its levels, is likelier than the logged stick, by kChanceChange.
/// @returns the end of a sentence about the stick; empty: the vehicle received the logged stick
std::string coarse_stick(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                         const Fit& fit);

struct ClockRate {
  double rate = 0.0;   ///< of StickClock; below 0: the sticks' clock is slower than the response's
  double sigma = 0.0;  ///< standard error of the rate
};

/// Tests for clocks of stick and response that run apart by up to 1.2 %, on the middle two minutes of the ranges.
/// @returns empty: they agree within kMinDelayChange_s from half to half, the likelihood ratio is below kChanceChange,
/// or a change in flight explains the same data better by more than that
std::optional<ClockRate> clock_rate(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                                    const Fit& fit);

/// A sentence about the clocks.
std::string describe(const ClockRate& clock);

}  // namespace m100::lab::identify
