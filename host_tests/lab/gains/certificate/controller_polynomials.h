// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "host_tests/lab/gains/certificate/taylor_model.h"
#include "host_tests/lab/gains/flown_loop.h"
#include "host_tests/lab/gains/margin_box.h"

namespace m100::lab::gains {

/// Variables of the loop: frequency, damping and rest of the delay of the vehicle, and the angle of z.
using LoopModel = TaylorModel<4>;
inline constexpr std::size_t kAngleVariable = 3;

/// The controller's response c (z - a)^-1 b + d as polynomials in z - 1: one numerator for each input over one
/// denominator. The coefficients are computed exactly in integers (Faddeev and LeVerrier), then rounded outwards once.
class ControllerPolynomials {
 public:
  explicit ControllerPolynomials(const LiftedSystem& controller);

  /// The controller over an arc of angles of z.
  struct OverArc {
    bool valid = false;  ///< false: no response, the arc is too long for its distance to a pole
    std::vector<ComplexNumber<LoopModel>> response;  ///< numerator over denominator
    std::vector<ComplexNumber<LoopModel>> numerators;
    ComplexNumber<LoopModel> denominator;
  };
  /// The response over an arc of the unit circle: a Taylor polynomial about the arc's middle and a bound of its error.
  /// Angles in [0, pi]; the other half of the circle follows from symmetry.
  OverArc over(const Range& angle) const;

  std::size_t degree() const { return denominator_.size() - 1; }

 private:
  std::vector<TaylorModel<1>> denominator_;              ///< by power of z - 1
  std::vector<std::vector<TaylorModel<1>>> numerators_;  ///< by input, then power
};

}  // namespace m100::lab::gains
