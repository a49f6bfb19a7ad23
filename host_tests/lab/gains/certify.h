// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host_tests/lab/gains/margin_box.h"

namespace m100::lab::gains {

/// What was proved of one structure, axis and channel.
struct CertifiedLoop {
  std::string structure;
  Axis axis = Axis::kX;
  bool by_sticks = true;
  AxisBox box;
  bool holds = false;
  double bound = 0.0;      ///< of the peak sensitivity, in the whole box
  double sampled = 0.0;    ///< the largest that was evaluated
  double low_rad_s = 0.0;  ///< below it the sensitivity is bounded by the maximum principle
  double low_bound = 0.0;  ///< of the sensitivity there
  std::size_t cells = 0;
  std::string why_not;
};

/// Proves, with outward rounding, that the loop as flown is stable and its peak sensitivity bounded on every aircraft
/// of the boxes of gain, frequency, damping and delay. The loop is L = gain K(z) Y(z; frequency, damping, delay), K the
/// controller and Y the vehicle in closed form.
///  1. At one aircraft in each tick of delay the closed loop is stable, by a power of its matrix.
///  2. Each cell of (frequency, damping, delay, angle of z) is enclosed by the mean value form: |L - L(middle)| <= sum
///  of
///     (largest derivative) (half width). If 1 + g L keeps away from 0 for all gains g, no pole crosses the unit
///     circle, and the distance bounds the sensitivity; otherwise the cell is halved where it matters most.
///  3. Near z = 1, where L has its integrators, 1/L is analytic if L has no zero there (argument principle), and so
///     largest on the circle around 1, which is covered by cells as in 2. Then S <= h / (g - h) with h >= |1/L|.
/// @param margin the bound is at most this times the largest sampled peak
std::vector<CertifiedLoop> certify(const model::Vehicle& believed, const std::vector<OpenStructure>& structures,
                                   double margin, const std::function<void(const CertifiedLoop&)>& progress);

}  // namespace m100::lab::gains
