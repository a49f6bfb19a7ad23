// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <complex>
#include <map>
#include <utility>
#include <vector>

#include "host_tests/lab/gains/certificate/controller_polynomials.h"
#include "host_tests/lab/gains/margin_box.h"
#include "host_tests/lab/gains/plant_response.h"

namespace m100::lab::gains {

/// Ranges of the variables of LoopModel: frequency [rad/s], damping, rest of the delay within its tick [s], angle of z.
struct LoopCell {
  std::array<Range, 4> range;
  int delay_ticks = 0;
  int pose_age_ticks = 2;  ///< true age of the position
  double middle(std::size_t k) const { return 0.5 * (range[k].low + range[k].high); }
  /// At least the distance from the middle to either end.
  double half(std::size_t k) const { return 0.5 * (range[k].high - range[k].low) * (1.0 + 1e-12) + 1e-300; }
  std::pair<LoopCell, LoopCell> halves(std::size_t k) const;
};

/// The loop of one structure, axis and channel at gain 1, enclosed over cells.
class EnclosedLoop {
 public:
  EnclosedLoop(const model::Vehicle& believed, const OpenStructure& structure, Axis axis, const LoopTiming& timing);

  /// In the cell L = middle + sum of slope_k t_k + curvature_k t_k^2 + r, |r| <= rest, t_k = (x_k - middle_k) / half_k.
  struct Expansion {
    bool valid = false;
    std::complex<double> middle;
    std::array<std::complex<double>, 4> slope{}, curvature{};
    double rest = 0.0;
    std::array<double, 4> share{};  ///< where to halve the cell: the variable with the largest number
  };
  Expansion over(const LoopCell& cell);

  /// 1 + g L times its denominators D (1 - 1/z) (1 - exp(-drag P)/z), as open + g driven; D is the controller's.
  struct Parts {
    ComplexNumber<LoopModel> open, driven;
  };
  Parts parts(const LoopCell& cell);

  std::size_t controller_degree() const { return polynomials_.degree(); }

 private:
  /// Fills response_ and returns its integrators.
  const ComplexNumber<LoopModel>& respond(const LoopCell& cell);
  const ControllerPolynomials::OverArc& controller_over(const Range& angle);

  LoopTiming timing_;
  ControllerPolynomials polynomials_;
  double stick_ = 1.0;
  double lead_s_ = 0.0, drag_per_s_ = 0.0, pull_m_s2_ = 0.0;
  std::vector<ComplexNumber<LoopModel>> response_;
  ComplexNumber<LoopModel> integrators_;
  std::map<std::pair<double, double>, ControllerPolynomials::OverArc> arcs_;
};

}  // namespace m100::lab::gains
