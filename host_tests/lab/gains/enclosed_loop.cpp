// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/enclosed_loop.h"

#include <algorithm>
#include <cmath>

namespace m100::lab::gains {
namespace {

/// Above the relative rounding error of the few operations between enclosed numbers and plain bounds.
constexpr double kSlack = 1e-13;

LiftedController lifted_controller(const FlownController& controller, const LoopTiming& timing) {
  return {controller, timing};
}

ComplexNumber<Enclosure> plain_value(const ComplexNumber<LoopJet>& jet) { return {jet.re.value, jet.im.value}; }

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
  const bool overdamped = cell.range[1].low > 1.0;
  const auto loop = [&](bool whole) {
    std::array<LoopJet, 4> at;
    for (std::size_t k = 0; k < 4; ++k) {
      const Range& range = cell.range[k];
      at[k] = LoopJet::variable(whole ? Enclosure(range.low, range.high) : Enclosure(cell.middle(k)), k);
    }
    const double middle = cell.middle(kAngleVariable);
    const ControllerPolynomials::OverArc& law =
        controller_over(whole ? cell.range[kAngleVariable] : Range{middle, middle});
    const ComplexNumber<LoopJet> integrators = respond(at, overdamped, delay_ticks, jets_);
    const auto numerator = [&](std::size_t k) -> const ComplexNumber<LoopJet>& { return law.numerators[k]; };
    return LoopJet(-stick_) * (loop_numerator(numerator, jets_, integrators) / (integrators * law.denominator));
  };
  out.middle = plain_value(loop(false));
  const ComplexNumber<LoopJet> all = loop(true);
  for (std::size_t k = 0; k < 4; ++k) {
    const Enclosure &re = all.re.by[k], &im = all.im.by[k];
    out.slope[k] = {re.middle(), im.middle()};
    out.share[k] = (1.0 + kSlack) * std::hypot(radius_of(re), radius_of(im)) * cell.half(k) +
                   kSlack * std::abs(out.slope[k]) * cell.half(k);
    out.rest += out.share[k];
  }
  out.rest = (1.0 + kSlack) * (out.rest + std::hypot(radius_of(out.middle.re), radius_of(out.middle.im)));
  out.valid = std::isfinite(out.rest);
  return out;
}

EnclosedLoop::Parts EnclosedLoop::parts(const LoopCell& cell, int delay_ticks) {
  std::array<Enclosure, 4> at;
  for (std::size_t k = 0; k < 4; ++k) {
    at[k] = Enclosure(cell.range[k].low, cell.range[k].high);
  }
  const ControllerPolynomials::OverArc& law = controller_over(cell.range[kAngleVariable]);
  const ComplexNumber<Enclosure> integrators = respond(at, cell.range[1].low > 1.0, delay_ticks, values_);
  const auto numerator = [&](std::size_t k) { return plain_value(law.numerators[k]); };
  return {.open = integrators * plain_value(law.denominator),
          .driven = Enclosure(-stick_) * loop_numerator(numerator, values_, integrators)};
}

const ControllerPolynomials::OverArc& EnclosedLoop::controller_over(const Range& angle) {
  const std::pair key{angle.low, angle.high};
  const auto found = arcs_.find(key);
  return found != arcs_.end() ? found->second
                              : arcs_.emplace(key, polynomials_.over(Enclosure(angle.low, angle.high))).first->second;
}

}  // namespace m100::lab::gains
