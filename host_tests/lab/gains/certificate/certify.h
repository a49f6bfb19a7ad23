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
  /// Of the sensitivity in the whole box.
  struct Peak {
    double bound = 0.0;
    double sampled = 0.0;  ///< the largest that was evaluated
  };
  Peak peak;               ///< with the pose as old as assumed
  Peak at_any_age;         ///< with the pose 0 ms to twice as old as assumed, in whole ticks of 10 ms
  double low_rad_s = 0.0;  ///< below it the loop gain alone bounds the sensitivity, down to z = 1
  double low_bound = 0.0;  ///< of the sensitivity there
  std::size_t cells = 0;
  std::string why_not;
};

/// Proves by Taylor models with outward rounding that the loop as flown is stable, and bounds its peak sensitivity, on
/// every aircraft of the boxes and for each age of the pose. The loop is L = gain N(z) Y(z; frequency, damping, delay)
/// / D(z): N and D are polynomials of the controller, Y is the response of the vehicle.
///  1. In each tick of delay, D (1 - 1/z) (1 - exp(-drag P)/z) (1 + L) of one aircraft has as many turns round 0 on the
///     unit circle as its degree: all its zeros lie inside.
///  2. Each cell of (frequency, damping, rest of the delay, angle of z) is enclosed by a polynomial and a bound of its
///     error. If 1 + L keeps away from 0 in the cell for all gains, no zero crosses the circle, and the distance bounds
///     the sensitivity. Otherwise the cell is halved.
///  3. Below 0.3 rad/s, z = 1 included: |1/L| <= h gives S <= h / (1 - h), without a division by the integrators.
/// @param margin largest allowed ratio of a bound to the largest sampled peak of all loops
std::vector<CertifiedLoop> certify(const model::Vehicle& believed, const std::vector<OpenStructure>& structures,
                                   double margin, const std::function<void(const CertifiedLoop&)>& progress);

}  // namespace m100::lab::gains
