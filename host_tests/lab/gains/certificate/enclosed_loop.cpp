// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/certificate/enclosed_loop.h"

#include <cmath>

namespace m100::lab::gains {
namespace {

/// Above the relative rounding error of the few operations between enclosed numbers and plain bounds.
constexpr double kSlack = 1e-13;

/// sum of the law's responses, or numerators, times the vehicle's: the position's terms carry the integrators already.
ComplexNumber<LoopModel> loop_numerator(const std::vector<ComplexNumber<LoopModel>>& law,
                                        const std::vector<ComplexNumber<LoopModel>>& vehicle,
                                        const ComplexNumber<LoopModel>& integrators) {
  ComplexNumber<LoopModel> positions, tilts;
  for (std::size_t k = 0; k < vehicle.size(); ++k) {
    ComplexNumber<LoopModel>& sum = k % 3 == 0 ? positions : tilts;
    sum = sum + law[k] * vehicle[k];
  }
  return positions + integrators * tilts;
}

}  // namespace

std::pair<LoopCell, LoopCell> LoopCell::halves(std::size_t k) const {
  std::pair<LoopCell, LoopCell> out{*this, *this};
  out.first.range[k].high = out.second.range[k].low = middle(k);
  return out;
}

EnclosedLoop::EnclosedLoop(const model::Vehicle& believed, const OpenStructure& structure, Axis axis,
                           const LoopTiming& timing)
    : timing_(timing), polynomials_(*FlownController(believed, axis, timing).lifted) {
  const model::StickAxis& of = attitude_of(structure.vehicle, axis);
  stick_ = FlownController(believed, axis, timing).stick_gain(of);
  lead_s_ = of.lead_zero_s;
  drag_per_s_ = structure.vehicle.translation.linear_drag_per_s;
  pull_m_s2_ = (axis == Axis::kX ? 1.0 : -1.0) * model::kGravity_m_s2 * structure.vehicle.translation.tilt_gain;
}

const ComplexNumber<LoopModel>& EnclosedLoop::respond(const LoopCell& cell) {
  std::array<LoopModel, 4> at;
  for (std::size_t k = 0; k < 4; ++k) {
    at[k] = LoopModel::variable(cell.range[k].low, cell.range[k].high, k);
  }
  const PlantParameters<LoopModel> plant{.frequency_rad_s = at[0],
                                         .damping = at[1],
                                         .rest_s = at[2],
                                         .lead_s = lead_s_,
                                         .drag_per_s = drag_per_s_,
                                         .pull_m_s2 = pull_m_s2_,
                                         .delay_ticks = cell.delay_ticks};
  integrators_ = plant_response<LoopModel>(plant, {cos(at[kAngleVariable]), sin(at[kAngleVariable])}, timing_,
                                           cell.pose_age_ticks, response_);
  return integrators_;
}

EnclosedLoop::Expansion EnclosedLoop::over(const LoopCell& cell) {
  Expansion out;
  const ControllerPolynomials::OverArc& law = controller_over(cell.range[kAngleVariable]);
  if (!law.valid) {
    out.share[kAngleVariable] = 1.0;
    return out;
  }
  const ComplexNumber<LoopModel>& integrators = respond(cell);
  const ComplexNumber<LoopModel> loop =
      LoopModel(-stick_) * (loop_numerator(law.response, response_, integrators) / integrators);
  out.middle = {loop.re.constant, loop.im.constant};
  out.rest = (1.0 + kSlack) * std::hypot(loop.re.rest, loop.im.rest);
  double all = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    out.slope[i] = {loop.re.linear[i], loop.im.linear[i]};
    out.curvature[i] = {loop.re.quadratic[i][i], loop.im.quadratic[i][i]};
    out.share[i] = std::abs(out.slope[i]) + std::abs(out.curvature[i]);  // a slope may vanish at the middle
    all += out.share[i];
  }
  for (std::size_t i = 0; i < 4; ++i) {
    out.share[i] = std::abs(out.curvature[i]) + out.rest * out.share[i] / all;
  }
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      const double mixed = (1.0 + kSlack) * std::hypot(loop.re.quadratic[i][j], loop.im.quadratic[i][j]);
      out.rest += mixed;
      out.share[i] += 0.5 * mixed;
      out.share[j] += 0.5 * mixed;
    }
  }
  out.rest *= 1.0 + kSlack;
  out.valid = std::isfinite(out.rest);
  if (!out.valid) {  // a quotient by a range that contains 0
    out.share = {cell.half(0) / cell.middle(0), cell.half(1) / cell.middle(1), 0.0,
                 0.5 * cell.half(3) / cell.middle(3)};
  }
  return out;
}

EnclosedLoop::Parts EnclosedLoop::parts(const LoopCell& cell) {
  const ControllerPolynomials::OverArc& law = controller_over(cell.range[kAngleVariable]);
  const ComplexNumber<LoopModel>& integrators = respond(cell);
  return {.open = integrators * law.denominator,
          .driven = LoopModel(-stick_) * loop_numerator(law.numerators, response_, integrators)};
}

const ControllerPolynomials::OverArc& EnclosedLoop::controller_over(const Range& angle) {
  const std::pair key{angle.low, angle.high};
  const auto found = arcs_.find(key);
  return found != arcs_.end() ? found->second : arcs_.emplace(key, polynomials_.over(angle)).first->second;
}

}  // namespace m100::lab::gains
