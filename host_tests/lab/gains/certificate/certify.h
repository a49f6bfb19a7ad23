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
  double low_rad_s = 0.0;  ///< below it the loop gain alone bounds the sensitivity, down to z = 1
  double low_bound = 0.0;  ///< of the sensitivity there
  std::size_t cells = 0;
  std::string why_not;
};

/// Proves, in interval arithmetic with outward rounding, that the loop as flown is stable and its peak sensitivity
/// bounded on every aircraft of the boxes of gain, frequency, damping and delay. The loop is L = gain N(z) Y(z;
/// frequency, damping, delay) / D(z): the controller as exact polynomials, the vehicle in closed form.
///  1. In each tick of delay, D (1 - 1/z) (1 - exp(-drag P)/z) (1 + L) of one aircraft has as many turns round 0 on the
///     unit circle as its degree: all its zeros lie inside.
///  2. Each cell of (frequency, damping, rest of the delay, angle of z) is enclosed by L(middle) + slopes (x - middle)
///     + a remainder of second order. One direction in which the distance from -1 is positive for all gains shows that
///     no zero crosses the circle, and bounds the sensitivity; otherwise the cell is halved where its remainder comes
///     from.
///  3. Below 0.3 rad/s, z = 1 included: |1/L| <= h gives S <= h / (1 - h), without a division by the integrators.
/// @param margin the bound is at most this times the largest sampled peak
std::vector<CertifiedLoop> certify(const model::Vehicle& believed, const std::vector<OpenStructure>& structures,
                                   double margin, const std::function<void(const CertifiedLoop&)>& progress);

}  // namespace m100::lab::gains
