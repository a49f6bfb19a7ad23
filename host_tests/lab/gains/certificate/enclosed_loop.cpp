// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/certificate/enclosed_loop.h"

#include <algorithm>
#include <cmath>

namespace m100::lab::gains {
namespace {

/// Above the relative rounding error of the few operations between enclosed numbers and plain bounds.
constexpr double kSlack = 1e-13;

LiftedController lifted_controller(const FlownController& controller, const LoopTiming& timing) {
  return {controller, timing};
}

double radius_of(const Enclosure& of) { return 0.5 * (of.high - of.low) * (1.0 + kSlack); }

/// sum of numerators times vehicle: the position's terms carry the integrators already.
template <typename R, typename Numerators>
ComplexNumber<R> loop_numerator(const Numerators& numerators, const std::vector<ComplexNumber<R>>& vehicle,
                                const ComplexNumber<R>& integrators) {
  ComplexNumber<R> positions, tilts;
  for (std::size_t k = 0; k < vehicle.size(); ++k) {
    ComplexNumber<R>& sum = k % 3 == 0 ? positions : tilts;
    sum = sum + numerators(k) * vehicle[k];
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
    : timing_(timing), polynomials_(lifted_controller(FlownController(believed, axis, timing), timing)) {
  const model::StickAxis& of = attitude_of(structure.vehicle, axis);
  const double scale = FlownController(believed, axis, timing).scale_per_count;
  stick_ = timing.by_sticks && scale > 0.0 ? of.scale_per_count / scale : 1.0;
  lead_s_ = of.lead_zero_s;
  drag_per_s_ = structure.vehicle.translation.linear_drag_per_s;
  pull_m_s2_ = (axis == Axis::kX ? 1.0 : -1.0) * model::kGravity_m_s2 * structure.vehicle.translation.tilt_gain;
}

template <typename R>
ComplexNumber<R> EnclosedLoop::respond(const std::array<R, 4>& at, bool overdamped, int delay_ticks,
                                       std::vector<ComplexNumber<R>>& out) const {
  const PlantParameters<R> plant{.frequency_rad_s = at[0],
                                 .damping = at[1],
                                 .rest_s = at[2],
                                 .lead_s = lead_s_,
                                 .drag_per_s = drag_per_s_,
                                 .pull_m_s2 = pull_m_s2_,
                                 .delay_ticks = delay_ticks,
                                 .overdamped = overdamped};
  return plant_response<R>(plant, {cos(at[kAngleVariable]), sin(at[kAngleVariable])}, timing_,
                           static_cast<int>(timing_.pose_age_ticks), out);
}

EnclosedLoop::Linear EnclosedLoop::over(const LoopCell& cell, int delay_ticks) {
  Linear out;
  const ControllerPolynomials::OverArc& law = controller_over(cell.range[kAngleVariable]);
  if (!law.valid) {
    out.share[kAngleVariable] = 1.0;
    return out;
  }
  std::array<LoopJet, 4> at;
  for (std::size_t k = 0; k < 4; ++k) {
    at[k] = LoopJet::variable({cell.range[k].low, cell.range[k].high}, k);
  }
  const ComplexNumber<LoopJet> integrators = respond(at, cell.range[1].low > 1.0, delay_ticks, jets_);
  const auto response = [&](std::size_t k) -> const ComplexNumber<LoopJet>& { return law.response[k]; };
  const ComplexNumber<LoopJet> loop = LoopJet(-stick_) * (loop_numerator(response, jets_, integrators) / integrators);
  out.middle = {loop.re.middle, loop.im.middle};
  for (std::size_t k = 0; k < 4; ++k) {
    const Enclosure &re = loop.re.by[k], &im = loop.im.by[k];
    out.slope[k] = {re.middle(), im.middle()};
    out.share[k] = (1.0 + kSlack) * std::hypot(radius_of(re), radius_of(im)) + kSlack * std::abs(out.slope[k]);
    out.rest += out.share[k];
  }
  out.rest = (1.0 + kSlack) * (out.rest + std::hypot(radius_of(out.middle.re), radius_of(out.middle.im)));
  out.valid = std::isfinite(out.rest);
  if (!out.valid) {  // a quotient by a range that contains 0
    out.share = {cell.half(0) / cell.middle(0), cell.half(1) / cell.middle(1), 0.0,
                 0.5 * cell.half(3) / cell.middle(3)};
  }
  return out;
}

EnclosedLoop::Parts EnclosedLoop::parts(const LoopCell& cell, int delay_ticks) {
  std::array<Enclosure, 4> at;
  for (std::size_t k = 0; k < 4; ++k) {
    at[k] = Enclosure(cell.range[k].low, cell.range[k].high);
  }
  const ControllerPolynomials::OverArc& law = controller_over(cell.range[kAngleVariable]);
  const ComplexNumber<Enclosure> integrators = respond(at, cell.range[1].low > 1.0, delay_ticks, values_);
  const auto numerator = [&](std::size_t k) -> const ComplexNumber<Enclosure>& { return law.numerators[k]; };
  return {.open = integrators * law.denominator,
          .driven = Enclosure(-stick_) * loop_numerator(numerator, values_, integrators)};
}

const ControllerPolynomials::OverArc& EnclosedLoop::controller_over(const Range& angle) {
  const std::pair key{angle.low, angle.high};
  const auto found = arcs_.find(key);
  return found != arcs_.end() ? found->second
                              : arcs_.emplace(key, polynomials_.over(Enclosure(angle.low, angle.high))).first->second;
}

}  // namespace m100::lab::gains
