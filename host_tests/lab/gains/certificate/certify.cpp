// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/certificate/certify.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

#include "host_tests/lab/gains/certificate/enclosed_loop.h"
#include "host_tests/lab/gains/plant_response.h"

namespace m100::lab::gains {
namespace {

constexpr double kLow_rad_s = 0.3;  ///< from here down the loop gain alone bounds the sensitivity
/// Cells of one loop after which the proof is given up: ten times what a loop well within the bound needs.
constexpr std::size_t kMaxCells = 300'000;
/// Above the rounding error of a sum of about ten terms.
constexpr double kRounding = 1e-14;

/// A lower bound of |1 + g L| over the cell and all gains g: the largest, over some directions, of the least component
/// of 1 + g L in that direction.
double distance_below(const EnclosedLoop::Expansion& loop, const Range& gain) {
  double size = std::abs(loop.middle) + loop.rest;
  for (std::size_t k = 0; k < 4; ++k) {
    size += std::abs(loop.slope[k]) + std::abs(loop.curvature[k]);
  }
  const double slack = kRounding * (1.0 + gain.high * size);
  const auto along = [&](double angle) {
    const std::complex<double> direction = std::polar(1.0, angle);
    const auto part = [&](const std::complex<double>& of) {
      return direction.real() * of.real() + direction.imag() * of.imag();
    };
    double least = part(loop.middle) - loop.rest;
    for (std::size_t k = 0; k < 4; ++k) {
      const double slope = std::abs(part(loop.slope[k])), curvature = part(loop.curvature[k]);
      const bool has_vertex = 2.0 * curvature > slope;
      least -= has_vertex ? slope * slope / (4.0 * curvature) : slope - curvature;
    }
    return (direction.real() + std::min(gain.low * least, gain.high * least) - slack) * (1.0 - kRounding);
  };
  const double at = std::clamp(-loop.middle.real() / std::max(std::norm(loop.middle), 1e-300), gain.low, gain.high);
  double best_angle = std::arg(1.0 + at * loop.middle), best = along(best_angle);
  for (double step = 0.8; step > 0.01; step *= 0.5) {
    for (const double angle : {best_angle - step, best_angle + step}) {
      if (const double one = along(angle); one > best) {
        best = one;
        best_angle = angle;
      }
    }
  }
  return best;
}

/// The delays of the box, cut at whole ticks: number of ticks, and range of the rest [s].
std::vector<std::pair<int, Range>> delays_of(const AxisBox& box) {
  std::vector<std::pair<int, Range>> out;
  const int first = static_cast<int>(std::floor(box.delay_s.low / kLoopTick_s + 1e-9));
  const int last = static_cast<int>(std::ceil(box.delay_s.high / kLoopTick_s - 1e-9));
  for (int tick = first; tick < std::max(last, first + 1); ++tick) {
    out.push_back({tick,
                   {std::max(0.0, box.delay_s.low - tick * kLoopTick_s),
                    std::min(kLoopTick_s, box.delay_s.high - tick * kLoopTick_s)}});
  }
  return out;
}

double middle_size(const ComplexNumber<LoopModel>& middle) {
  return std::hypot(middle.re.constant, middle.im.constant);
}
double reach_of(const ComplexNumber<LoopModel>& of) {
  return (1.0 + kRounding) * std::hypot(of.re.reach(), of.im.reach());
}
double least_size(const ComplexNumber<LoopModel>& of) { return (1.0 - kRounding) * middle_size(of) - reach_of(of); }
double greatest_size(const ComplexNumber<LoopModel>& of) { return (1.0 + kRounding) * middle_size(of) + reach_of(of); }

/// The proof of one loop. Every step returns false and sets `why_not` if it finds no proof.
class Proof {
 public:
  Proof(EnclosedLoop& loop, double frequency_rad_s, const LoopTiming& timing, double margin, CertifiedLoop& out)
      : loop_(loop),
        frequency_rad_s_(frequency_rad_s),
        timing_(timing),
        margin_(margin),
        low_(kLow_rad_s * kLoopTick_s * static_cast<double>(timing.command_ticks)),
        out_(out) {
    out_.low_rad_s = kLow_rad_s;
  }

  bool run() {
    const int assumed = static_cast<int>(timing_.pose_age_ticks);
    for (int age = 0; age <= 2 * assumed; ++age) {
      peak_ = age == assumed ? &out_.peak : &out_.at_any_age;
      for (const auto& [tick, rest] : delays_of(out_.box)) {
        const Range frequency{out_.box.frequency.low * frequency_rad_s_, out_.box.frequency.high * frequency_rad_s_};
        const LoopCell box{{frequency, out_.box.damping, rest}, tick, age};
        if (!turns_as_a_stable_loop(box) || !bound_low_end(box) || !cover_circle(box)) {
          return false;
        }
      }
    }
    out_.peak.bound = std::max(out_.peak.bound, out_.low_bound);
    out_.at_any_age.bound = std::max(out_.at_any_age.bound, out_.peak.bound);
    return true;
  }

 private:
  static LoopCell over(LoopCell box, const Range& angle) {
    box.range[kAngleVariable] = angle;
    return box;
  }
  bool may_go_on(const LoopCell& at) {
    if (++out_.cells <= kMaxCells) {
      return true;
    }
    char text[240];
    std::snprintf(
        text, sizeof text,
        "no bound after %zu cells; the last at frequency x %.3f, damping %.3f, delay %.1f ms, pose %d ms old, "
        "angle %.4f",
        out_.cells, at.middle(0) / frequency_rad_s_, at.middle(1), 10.0 * at.delay_ticks + 1e3 * at.middle(2),
        10 * at.pose_age_ticks, at.middle(kAngleVariable));
    out_.why_not = text;
    return false;
  }

  /// Step 1 of certify(): shows that the aircraft in the middle of the box is stable.
  bool turns_as_a_stable_loop(LoopCell middle) {
    for (std::size_t k = 0; k < 3; ++k) {
      middle.range[k] = {middle.middle(k), middle.middle(k)};
    }
    const auto value = [&](const Range& angle) {
      middle.range[kAngleVariable] = angle;
      const EnclosedLoop::Parts parts = loop_.parts(middle);
      return parts.open + parts.driven;
    };
    const auto at = [&](double angle) {
      const ComplexNumber<LoopModel> number = value({angle, angle});
      return std::complex<double>(number.re.constant, number.im.constant);
    };
    double turned = 0.0;
    std::vector<Range> left{{0.0, std::numbers::pi}};
    while (!left.empty()) {
      const Range arc = left.back();
      left.pop_back();
      if (!may_go_on(middle)) {
        return false;
      }
      if (least_size(value(arc)) > 0.0) {  // the arc stays in a half-plane, so the principal value is its turn
        turned += std::arg(at(arc.high) / at(arc.low));
        continue;
      }
      const double between = 0.5 * (arc.low + arc.high);
      left.push_back({arc.low, between});
      left.push_back({between, arc.high});
    }
    const double expected = std::numbers::pi * static_cast<double>(loop_.controller_degree());
    if (std::abs(turned - expected) > 0.1) {
      out_.why_not =
          "unstable in the middle of its box, at a delay of " + std::to_string(10 * middle.delay_ticks) + " ms";
      return false;
    }
    return true;
  }

  /// Step 3 of certify(): bounds the sensitivity at low frequencies.
  bool bound_low_end(const LoopCell& box) {
    constexpr double kMaxShare = 0.5;  // S <= 1 then
    std::vector<LoopCell> left{over(box, {0.0, low_})};
    while (!left.empty()) {
      const LoopCell at = left.back();
      left.pop_back();
      if (!may_go_on(at)) {
        return false;
      }
      const EnclosedLoop::Parts parts = loop_.parts(at);
      const double share = greatest_size(parts.open) / (out_.box.gain.low * least_size(parts.driven));
      if (share >= 0.0 && share < kMaxShare) {
        out_.low_bound = std::max(out_.low_bound, (1.0 + kRounding) * share / (1.0 - share));
        continue;
      }
      std::size_t widest = kAngleVariable;
      double width = at.half(widest) / low_;
      for (std::size_t k = 0; k < 3; ++k) {
        const double share_of_value = at.half(k) / std::max(at.middle(k), 0.5 * kLoopTick_s);
        widest = share_of_value > width ? k : widest;
        width = std::max(width, share_of_value);
      }
      const auto [first, second] = at.halves(widest);
      left.push_back(first);
      left.push_back(second);
    }
    return true;
  }

  /// Step 2 of certify(): bounds the sensitivity on the rest of the unit circle.
  bool cover_circle(const LoopCell& box) {
    std::vector<LoopCell> left{over(box, {low_, std::numbers::pi})};
    while (!left.empty()) {
      const LoopCell at = left.back();
      left.pop_back();
      if (!may_go_on(at)) {
        return false;
      }
      const EnclosedLoop::Expansion loop = loop_.over(at);
      if (loop.valid) {
        const EnclosedLoop::Expansion middle{.valid = true, .middle = loop.middle};
        const double here = distance_below(middle, out_.box.gain);
        peak_->sampled = here > 0.0 ? std::max(peak_->sampled, 1.0 / here) : peak_->sampled;
        const double least = distance_below(loop, out_.box.gain);
        if (least * margin_ * peak_->sampled >= 1.0) {
          peak_->bound = std::max(peak_->bound, (1.0 + kRounding) / least);
          continue;
        }
      }
      const auto widest = std::max_element(loop.share.begin(), loop.share.end()) - loop.share.begin();
      const auto [first, second] = at.halves(static_cast<std::size_t>(widest));
      left.push_back(first);
      left.push_back(second);
    }
    return true;
  }

  EnclosedLoop& loop_;
  double frequency_rad_s_;
  LoopTiming timing_;
  double margin_;
  double low_;  ///< angle of z at kLow_rad_s
  CertifiedLoop& out_;
  CertifiedLoop::Peak* peak_ = nullptr;  ///< of the present age of the pose
};

}  // namespace

std::vector<CertifiedLoop> certify(const model::Vehicle& believed, const std::vector<OpenStructure>& structures,
                                   double margin, const std::function<void(const CertifiedLoop&)>& progress) {
  // One bound for all loops: a loop with a small peak need not be known to a hundredth.
  const MarginBox margins(structures);
  const double sampled = margins.worst(believed, MarginBox::Extent::kCertified).peak_sensitivity;
  const double at_any_age = margins.worst(believed, MarginBox::Extent::kBox).peak_sensitivity;
  std::vector<CertifiedLoop> all;
  for (const OpenStructure& structure : structures) {
    for (const Axis axis : {Axis::kX, Axis::kY}) {
      for (const LoopTiming& timing : {kVirtualRcTiming, kMovementTiming}) {
        CertifiedLoop out{.structure = structure.name,
                          .axis = axis,
                          .by_sticks = timing.by_sticks,
                          .box = structure.box[axis == Axis::kX ? 0 : 1],
                          .peak = {.sampled = sampled},
                          .at_any_age = {.sampled = at_any_age},
                          .why_not = ""};
        EnclosedLoop loop(believed, structure, axis, timing);
        out.holds =
            Proof(loop, attitude_of(structure.vehicle, axis).natural_frequency_rad_s, timing, margin, out).run();
        progress(out);
        all.push_back(std::move(out));
      }
    }
  }
  return all;
}

}  // namespace m100::lab::gains
