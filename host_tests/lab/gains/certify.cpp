// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/certify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "host_tests/lab/gains/controller_enclosure.h"
#include "host_tests/lab/gains/plant_response.h"

namespace m100::lab::gains {
namespace {

constexpr double kDelayTick_s = 0.01;
constexpr std::size_t kMaxCells = 3'000'000;
constexpr int kRootArcs = 48;
constexpr int kCircleArcs = 24;

/// Variables 0 to 3: frequency [rad/s], damping, rest of the delay within its tick [s], angle.
struct Cell {
  std::array<Range, 4> range;
  double middle(std::size_t k) const { return 0.5 * (range[k].low + range[k].high); }
  double half(std::size_t k) const { return 0.5 * (range[k].high - range[k].low) * (1.0 + 1e-12) + 1e-300; }
};

/// The loop of one structure, axis and channel, with gain 1, enclosed.
class EnclosedLoop {
 public:
  EnclosedLoop(const model::Vehicle& believed, const OpenStructure& structure, Axis axis, const Way& way)
      : way_(way), controller_(believed, axis, way), lifted_(controller_, way) {
    const model::StickAxis& of = attitude_of(structure.vehicle, axis);
    const double scale = controller_.scale_per_count;
    stick_ = way.by_sticks && scale > 0.0 ? of.scale_per_count / scale : 1.0;
    lead_s_ = of.lead_zero_s;
    drag_per_s_ = structure.vehicle.translation.linear_drag_per_s;
    pull_m_s2_ = (axis == Axis::kX ? 1.0 : -1.0) * model::kGravity_m_s2 * structure.vehicle.translation.tilt_gain;
  }

  struct Value {
    bool valid = false;
    ComplexNumber<Enclosure> middle;  ///< L at the middle of the cell
    double radius = 0.0;              ///< |L - middle| at most, in the cell
    std::array<double, 4> share{};    ///< of the radius, by variable
  };
  Value over(const Cell& cell, int delay_ticks, double around_one) {
    const Arc arc{cell.range[3].low, cell.range[3].high, around_one};
    Value out;
    const ControllerEnclosure& law = controller_over(arc);
    if (!law.valid) {
      return out;
    }
    out.middle = loop_at_middle(cell, arc, law.middle, delay_ticks);
    const ComplexNumber<LoopJet> all = loop_over(cell, arc, law.over, delay_ticks);
    out.radius = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      const double slope = std::hypot(all.re.by[k].magnitude(), all.im.by[k].magnitude());
      out.share[k] = (1.0 + 1e-14) * slope * cell.half(k);
      out.radius += out.share[k];
    }
    out.radius *= 1.0 + 1e-14;
    out.valid = std::isfinite(out.radius);
    return out;
  }
  const FlownController& controller() const { return controller_; }
  const LiftedController& lifted() const { return lifted_; }
  double stick() const { return stick_; }

 private:
  /// The numbers of the vehicle, in R.
  template <typename R>
  PlantParameters<R> plant(const R& frequency, const R& damping, const R& rest, const Cell& cell, int ticks) const {
    return {.frequency_rad_s = frequency,
            .damping = damping,
            .rest_s = rest,
            .lead_s = lead_s_,
            .drag_per_s = drag_per_s_,
            .pull_m_s2 = pull_m_s2_,
            .delay_ticks = ticks,
            .overdamped = cell.range[1].low > 1.0};
  }
  ComplexNumber<LoopJet> loop_over(const Cell& cell, const Arc& arc, const std::vector<ComplexNumber<LoopJet>>& law,
                                   int delay_ticks) {
    const auto variable = [&](std::size_t k) {
      return LoopJet::variable(Enclosure(cell.range[k].low, cell.range[k].high), k);
    };
    plant_response<LoopJet>(plant(variable(0), variable(1), variable(2), cell, delay_ticks),
                            point_on(arc, Enclosure(arc.low, arc.high)), way_, static_cast<int>(way_.pose_age_ticks),
                            response_);
    ComplexNumber<LoopJet> sum;
    for (std::size_t k = 0; k < law.size(); ++k) {
      sum = sum + law[k] * response_[k];
    }
    return LoopJet(-stick_) * sum;
  }
  ComplexNumber<Enclosure> loop_at_middle(const Cell& cell, const Arc& arc,
                                          const std::vector<ComplexNumber<LoopJet>>& law, int delay_ticks) {
    const auto number = [&](std::size_t k) { return Enclosure(cell.middle(k)); };
    const ComplexNumber<LoopJet> z = point_on(arc, Enclosure(arc.middle()));
    plant_response<Enclosure>(plant(number(0), number(1), number(2), cell, delay_ticks), {z.re.value, z.im.value}, way_,
                              static_cast<int>(way_.pose_age_ticks), middle_response_);
    ComplexNumber<Enclosure> sum;
    for (std::size_t k = 0; k < law.size(); ++k) {
      sum = sum + ComplexNumber<Enclosure>{law[k].re.value, law[k].im.value} * middle_response_[k];
    }
    return Enclosure(-stick_) * sum;
  }
  const ControllerEnclosure& controller_over(const Arc& arc) {
    const auto key = std::array{arc.low, arc.high, arc.around_one};
    const auto found = laws_.find(key);
    return found != laws_.end() ? found->second : laws_.emplace(key, enclose_controller(lifted_, arc)).first->second;
  }

  Way way_;
  FlownController controller_;
  LiftedController lifted_;
  double stick_ = 1.0;
  double lead_s_ = 0.0, drag_per_s_ = 0.0, pull_m_s2_ = 0.0;
  std::vector<ComplexNumber<LoopJet>> response_;
  std::vector<ComplexNumber<Enclosure>> middle_response_;
  std::map<std::array<double, 3>, ControllerEnclosure> laws_;
};

/// A lower bound of |1 + g L| for all g in the range.
double distance_below(const ComplexNumber<Enclosure>& loop, const Range& gain) {
  const double re = loop.re.middle(), im = loop.im.middle();
  const double error = 0.5 * std::hypot(loop.re.high - loop.re.low, loop.im.high - loop.im.low);
  const double at = std::clamp(-re / std::max(re * re + im * im, 1e-300), gain.low, gain.high);
  return (1.0 - 1e-13) * std::hypot(1.0 + at * re, at * im) - gain.high * error - 1e-13;
}

/// The delays of the box, by tick.
std::vector<std::pair<int, Range>> delays_of(const AxisBox& box) {
  std::vector<std::pair<int, Range>> out;
  const int first = static_cast<int>(std::floor(box.delay_s.low / kDelayTick_s + 1e-9));
  const int last = static_cast<int>(std::ceil(box.delay_s.high / kDelayTick_s - 1e-9));
  for (int tick = first; tick < std::max(last, first + 1); ++tick) {
    out.push_back({tick,
                   {std::max(0.0, box.delay_s.low - tick * kDelayTick_s),
                    std::min(kDelayTick_s, box.delay_s.high - tick * kDelayTick_s)}});
  }
  return out;
}

class Proof {
 public:
  Proof(EnclosedLoop& loop, const AxisBox& box, double frequency_rad_s, double margin, CertifiedLoop& out)
      : loop_(loop), box_(box), frequency_rad_s_(frequency_rad_s), margin_(margin), out_(out) {}

  /// Covers the unit circle from `lowest` to pi for every delay of the box.
  bool cover_circle(double lowest) {
    for (const auto& [tick, rest] : delays_of(box_)) {
      for (int k = kRootArcs - 1; k >= 0; --k) {
        const double ratio = std::numbers::pi / lowest;
        const auto edge = [&](int at) {
          return at == kRootArcs ? std::numbers::pi : lowest * std::pow(ratio, double(at) / kRootArcs);
        };
        if (!cover(root(rest, {edge(k), edge(k + 1)}), tick)) {
          return false;
        }
      }
    }
    return true;
  }

  /// Covers the circle around 1. @returns an upper bound of |1/L| on it; 0: none. @param turns receives how often L
  /// turns round 0 on the whole circle
  double cover_around_one(double radius, int tick, const Range& rest, double& turns) {
    double greatest = 0.0, turned = 0.0;
    std::complex<double> before = 0.0;
    for (int k = 0; k < kCircleArcs; ++k) {
      std::vector<Cell> left{
          root(rest, {std::numbers::pi * k / kCircleArcs, std::numbers::pi * (k + 1) / kCircleArcs})};
      while (!left.empty()) {
        const Cell cell = left.back();
        left.pop_back();
        const EnclosedLoop::Value value = loop_.over(cell, tick, radius);
        const double size = std::hypot(value.middle.re.middle(), value.middle.im.middle());
        const double error =
            std::hypot(value.middle.re.high - value.middle.re.low, value.middle.im.high - value.middle.im.low);
        if (++out_.cells > kMaxCells) {
          return 0.0;
        }
        if (!value.valid || value.radius + error > 0.5 * size) {
          halve(cell, value, left);
          continue;
        }
        greatest = std::max(greatest, (1.0 + 1e-13) / (size - value.radius - error));
      }
      for (int i = 0; i <= 20; ++i) {  // the turns, at the structure itself
        const double angle = std::numbers::pi * (k + i / 20.0) / kCircleArcs;
        Cell at = root(rest, {angle, angle});
        for (std::size_t v = 0; v < 3; ++v) {
          at.range[v] = {at.middle(v), at.middle(v)};
        }
        const ComplexNumber<Enclosure> value = loop_.over(at, tick, radius).middle;
        const std::complex<double> now(value.re.middle(), value.im.middle());
        turned += before == 0.0 ? 0.0 : std::arg(now / before);
        before = now;
      }
    }
    turns = turned / std::numbers::pi;
    return greatest;
  }

 private:
  Cell root(const Range& rest, const Range& angle) const {
    return {{Range{box_.frequency.low * frequency_rad_s_, box_.frequency.high * frequency_rad_s_}, box_.damping, rest,
             angle}};
  }
  static void halve(const Cell& cell, const EnclosedLoop::Value& value, std::vector<Cell>& into) {
    std::size_t widest = 3;
    for (std::size_t k = 0; value.valid && k < 4; ++k) {
      widest = value.share[k] > value.share[widest] ? k : widest;
    }
    Cell low = cell, high = cell;
    low.range[widest].high = high.range[widest].low = cell.middle(widest);
    into.push_back(low);
    into.push_back(high);
  }
  bool cover(const Cell& whole, int tick) {
    const Range gain = box_.gain;
    std::vector<Cell> left{whole};
    while (!left.empty()) {
      const Cell cell = left.back();
      left.pop_back();
      if (++out_.cells > kMaxCells) {
        out_.why_not = "too many cells";
        return false;
      }
      const EnclosedLoop::Value value = loop_.over(cell, tick, 0.0);
      const double distance = value.valid ? distance_below(value.middle, gain) : 0.0;
      if (value.valid && distance > 0.0) {
        out_.sampled = std::max(out_.sampled, 1.0 / distance);
      }
      const double least = distance - gain.high * value.radius;
      if (value.valid && least > 0.0 && 1.0 / least <= margin_ * out_.sampled) {
        out_.bound = std::max(out_.bound, (1.0 + 1e-13) / least);
        continue;
      }
      halve(cell, value, left);
    }
    return true;
  }

  EnclosedLoop& loop_;
  const AxisBox& box_;
  double frequency_rad_s_;
  double margin_;
  CertifiedLoop& out_;
};

/// Step 1. The structure in the middle of each tick of delay of its box.
bool stable_in_every_tick(const EnclosedLoop& loop, const OpenStructure& structure, Axis axis, const Way& way,
                          const AxisBox& box) {
  for (const auto& [tick, rest] : delays_of(box)) {
    model::Vehicle truth = structure.vehicle;
    (axis == Axis::kX ? truth.pitch : truth.roll).transport_delay_s =
        tick * kDelayTick_s + 0.5 * (rest.low + rest.high);
    if (!FlownLoop(loop.controller(), truth, axis, way).closed_is_stable()) {
      return false;
    }
  }
  return true;
}

/// Step 3. @returns the radius of the circle around 1; 0: no radius will do
double certify_low_end(EnclosedLoop& loop, Proof& proof, const AxisBox& box, double period_s, CertifiedLoop& out) {
  constexpr double kPlantPoles = 2.0;  // at 1 and at exp(-drag period)
  for (const double w : {0.4, 0.3, 0.2, 0.6, 0.1, 0.8}) {
    const double radius = 2.0 * std::sin(0.5 * w * period_s);
    const int poles = eigenvalues_near_one(loop.lifted(), radius);
    double greatest = 0.0;
    bool analytic = poles >= 0;
    for (const auto& [tick, rest] : delays_of(box)) {
      double turns = 0.0;
      const double here = analytic ? proof.cover_around_one(radius, tick, rest, turns) : 0.0;
      analytic = analytic && here > 0.0 && std::abs(turns + kPlantPoles + poles) < 0.01;
      greatest = std::max(greatest, here);
    }
    if (analytic && greatest < 0.5 * box.gain.low) {
      out.low_rad_s = w;
      out.low_bound = greatest / (box.gain.low - greatest);
      return radius;
    }
  }
  return 0.0;
}

}  // namespace

std::vector<CertifiedLoop> certify(const model::Vehicle& believed, const std::vector<OpenStructure>& structures,
                                   double margin, const std::function<void(const CertifiedLoop&)>& progress) {
  std::vector<CertifiedLoop> all;
  double sampled = 1.0;  // one bound for all loops: a calm loop need not be known to a hundredth
  const MarginBox samples(structures, 200);
  for (std::size_t k = 0; k < structures.size(); ++k) {
    for (const Axis axis : {Axis::kX, Axis::kY}) {
      for (const Way& way : {kVirtualRcWay, kMovementWay}) {
        const BoxSelection only{.structure = k, .axis = axis, .by_sticks = way.by_sticks};
        sampled = std::max(sampled, samples.worst(believed, MarginBox::Extent::kCertified, only).peak_sensitivity);
      }
    }
  }
  for (const OpenStructure& structure : structures) {
    for (const Axis axis : {Axis::kX, Axis::kY}) {
      for (const Way& way : {kVirtualRcWay, kMovementWay}) {
        const AxisBox& box = structure.box[axis == Axis::kX ? 0 : 1];
        CertifiedLoop out{.structure = structure.name,
                          .axis = axis,
                          .by_sticks = way.by_sticks,
                          .box = box,
                          .sampled = sampled,
                          .why_not = ""};
        const double period_s = kDelayTick_s * static_cast<double>(way.command_ticks);
        EnclosedLoop loop(believed, structure, axis, way);
        Proof proof(loop, box, attitude_of(structure.vehicle, axis).natural_frequency_rad_s, margin, out);
        if (box.damping.low <= 1.0 && box.damping.high >= 1.0) {
          out.why_not = "the damping may be critical";
        } else if (!stable_in_every_tick(loop, structure, axis, way, box)) {
          out.why_not = "unstable";
        } else if (const double radius = certify_low_end(loop, proof, box, period_s, out); radius == 0.0) {
          out.why_not = "the low frequencies could not be bounded";
        } else {
          out.holds = proof.cover_circle(2.0 * std::asin(0.5 * radius) * (1.0 - 1e-12));
        }
        out.bound = std::max(out.bound, out.low_bound);
        progress(out);
        all.push_back(std::move(out));
      }
    }
  }
  return all;
}

}  // namespace m100::lab::gains
