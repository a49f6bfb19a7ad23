// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <vector>

#include "host_tests/lab/gains/enclosure.h"
#include "host_tests/lab/gains/flown_loop.h"

namespace m100::lab::gains {

/// Points z of an arc: of the unit circle, exp(i angle), or of the circle around 1 of radius `around_one`, 1 +
/// radius exp(i angle). Angles in [0, pi]; the rest follows from symmetry.
struct Arc {
  double low = 0.0;
  double high = 0.0;
  double around_one = 0.0;  ///< 0: the unit circle

  double middle() const { return 0.5 * (low + high); }
};

/// z over the arc, and over its middle alone; variable 3 of the jets is the angle.
using LoopJet = EnclosedJet<4>;
inline constexpr std::size_t kAngleVariable = 3;
ComplexNumber<LoopJet> point_on(const Arc& arc, const Enclosure& angle);

/// The controller's response over an arc, one number for each input, with its derivative by the angle.
struct ControllerEnclosure {
  bool valid = false;                          ///< false: the arc is too long for the bound; halve it
  std::vector<ComplexNumber<LoopJet>> over;    ///< the whole arc
  std::vector<ComplexNumber<LoopJet>> middle;  ///< its middle
};

/// Encloses c (z - a)^-1 b + d, in coordinates in which a is nearly triangular. With an approximate inverse X of z0 -
/// a, the row y = c (z - a)^-1 solves y = c X + y E, E = 1 - (z - a) X; if |E| <= e and a row r >= |c X| e + r e
/// exists, y lies within r of c X (Krawczyk). The same bounds y (z - a)^-1, which gives the derivative.
ControllerEnclosure enclose_controller(const LiftedController& controller, const Arc& arc);

/// How many eigenvalues of the controller lie within `radius` of 1: the turns of det(z - a) on that circle,
/// in floating point, in steps that turn by less than half a radian.
/// @returns -1 if an eigenvalue is too close to the circle
int eigenvalues_near_one(const LiftedController& controller, double radius);

}  // namespace m100::lab::gains
