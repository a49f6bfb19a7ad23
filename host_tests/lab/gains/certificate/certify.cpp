// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/certificate/certify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

#include "host_tests/lab/gains/certificate/enclosed_loop.h"

namespace m100::lab::gains {
namespace {

constexpr double kDelayTick_s = 0.01;
constexpr double kLow_rad_s = 0.3;  ///< from here down the loop gain alone bounds the sensitivity
/// Cells of one loop after which the proof is given up: more than fifty times what a loop with room needs.
constexpr std::size_t kMaxCells = 300'000;
/// Above the rounding error of a sum of about ten terms.
constexpr double kRounding = 1e-14;

/// A lower bound of the distance from 0 of all 1 + g L in the cell: the best of some directions, each of which gives
/// one because 1 + g L along a direction is linear in the gain and in the variables.
double distance_below(const EnclosedLoop::Linear& loop, const Range& gain) {
  const double re = loop.middle.re.middle(), im = loop.middle.im.middle();
  double size = std::hypot(re, im) + loop.rest;
  for (std::size_t k = 0; k < 4; ++k) {
    size += std::abs(loop.slope[k]);
  }
  const double slack = kRounding * (1.0 + gain.high * size);
  const auto along = [&](double angle) {
    const double x = std::cos(angle), y = std::sin(angle);
    double least = x * re + y * im - loop.rest;
    for (std::size_t k = 0; k < 4; ++k) {
      least -= std::abs(x * loop.slope[k].real() + y * loop.slope[k].imag());
    }
    return (x + std::min(gain.low * least, gain.high * least) - slack) * (1.0 - kRounding);
  };
  const double at = std::clamp(-re / std::max(re * re + im * im, 1e-300), gain.low, gain.high);
  double best_angle = std::atan2(at * im, 1.0 + at * re), best = along(best_angle);
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

double least_size(const ComplexNumber<Enclosure>& of) {
  const auto least = [](const Enclosure& x) {
    return x.contains(0.0) ? 0.0 : std::min(std::abs(x.low), std::abs(x.high));
  };
  return (1.0 - kRounding) * std::hypot(least(of.re), least(of.im));
}
double greatest_size(const ComplexNumber<Enclosure>& of) {
  return (1.0 + kRounding) * std::hypot(of.re.magnitude(), of.im.magnitude());
}

/// The proof of one loop. Every step returns false, with `why_not`, if it finds none.
class Proof {
 public:
  Proof(EnclosedLoop& loop, double frequency_rad_s, double period_s, double margin, CertifiedLoop& out)
      : loop_(loop), frequency_rad_s_(frequency_rad_s), margin_(margin), low_(kLow_rad_s * period_s), out_(out) {
    out_.low_rad_s = kLow_rad_s;
  }

  bool run() {
    if (out_.box.damping.low <= 1.0 && out_.box.damping.high >= 1.0) {
      out_.why_not = "the damping may be critical";
      return false;
    }
    for (const auto& [tick, rest] : delays_of(out_.box)) {
      if (!turns_as_a_stable_loop(tick, rest) || !bound_low_end(tick, rest) || !cover_circle(tick, rest)) {
        return false;
      }
    }
    out_.bound = std::max(out_.bound, out_.low_bound);
    return true;
  }

 private:
  LoopCell cell(const Range& rest, const Range& angle) const {
    const Range frequency{out_.box.frequency.low * frequency_rad_s_, out_.box.frequency.high * frequency_rad_s_};
    return {{frequency, out_.box.damping, rest, angle}};
  }
  bool may_go_on(const LoopCell& at, int tick) {
    if (++out_.cells <= kMaxCells) {
      return true;
    }
    char text[200];
    std::snprintf(text, sizeof text,
                  "no bound after %zu cells; the last at frequency x %.3f, damping %.3f, delay %.1f ms, angle %.4f",
                  out_.cells, at.middle(0) / frequency_rad_s_, at.middle(1), 10.0 * tick + 1e3 * at.middle(2),
                  at.middle(kAngleVariable));
    out_.why_not = text;
    return false;
  }

  /// Step 1, for the aircraft in the middle of the box.
  bool turns_as_a_stable_loop(int tick, const Range& rest) {
    LoopCell middle = cell(rest, {});
    for (std::size_t k = 0; k < 3; ++k) {
      middle.range[k] = {middle.middle(k), middle.middle(k)};
    }
    const auto value = [&](const Range& angle) {
      middle.range[kAngleVariable] = angle;
      const EnclosedLoop::Parts parts = loop_.parts(middle, tick);
      return parts.open + parts.driven;
    };
    const auto at = [&](double angle) {
      const ComplexNumber<Enclosure> number = value({angle, angle});
      return std::complex<double>(number.re.middle(), number.im.middle());
    };
    double turned = 0.0;
    std::vector<Range> left{{0.0, std::numbers::pi}};
    while (!left.empty()) {
      const Range arc = left.back();
      left.pop_back();
      if (!may_go_on(middle, tick)) {
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
      out_.why_not = "unstable in the middle of its box, at a delay of " + std::to_string(10 * tick) + " ms";
      return false;
    }
    return true;
  }

  /// Step 3.
  bool bound_low_end(int tick, const Range& rest) {
    constexpr double kMaxShare = 0.5;  // S <= 1 then
    std::vector<LoopCell> left{cell(rest, {0.0, low_})};
    while (!left.empty()) {
      const LoopCell at = left.back();
      left.pop_back();
      if (!may_go_on(at, tick)) {
        return false;
      }
      const EnclosedLoop::Parts parts = loop_.parts(at, tick);
      const double share = greatest_size(parts.open) / (out_.box.gain.low * least_size(parts.driven));
      if (share < kMaxShare) {
        out_.low_bound = std::max(out_.low_bound, (1.0 + kRounding) * share / (1.0 - share));
        continue;
      }
      std::size_t widest = kAngleVariable;
      double width = at.half(widest) / low_;
      for (std::size_t k = 0; k < 3; ++k) {
        const double share_of_value = at.half(k) / std::max(at.middle(k), 0.5 * kDelayTick_s);
        widest = share_of_value > width ? k : widest;
        width = std::max(width, share_of_value);
      }
      const auto [first, second] = at.halves(widest);
      left.push_back(first);
      left.push_back(second);
    }
    return true;
  }

  /// Step 2.
  bool cover_circle(int tick, const Range& rest) {
    std::vector<LoopCell> left{cell(rest, {low_, std::numbers::pi})};
    while (!left.empty()) {
      const LoopCell at = left.back();
      left.pop_back();
      if (!may_go_on(at, tick)) {
        return false;
      }
      const EnclosedLoop::Linear loop = loop_.over(at, tick);
      if (loop.valid) {
        const EnclosedLoop::Linear middle{.valid = true, .middle = loop.middle};
        const double here = distance_below(middle, out_.box.gain);
        out_.sampled = here > 0.0 ? std::max(out_.sampled, 1.0 / here) : out_.sampled;
        const double least = distance_below(loop, out_.box.gain);
        if (least * margin_ * out_.sampled >= 1.0) {
          out_.bound = std::max(out_.bound, (1.0 + kRounding) / least);
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
  double margin_;
  double low_;  ///< angle
  CertifiedLoop& out_;
};

}  // namespace

std::vector<CertifiedLoop> certify(const model::Vehicle& believed, const std::vector<OpenStructure>& structures,
                                   double margin, const std::function<void(const CertifiedLoop&)>& progress) {
  // One bound for all loops: a calm loop need not be known to a hundredth.
  const double sampled = MarginBox(structures, 200).worst(believed, MarginBox::Extent::kCertified).peak_sensitivity;
  std::vector<CertifiedLoop> all;
  for (const OpenStructure& structure : structures) {
    for (const Axis axis : {Axis::kX, Axis::kY}) {
      for (const LoopTiming& timing : {kVirtualRcTiming, kMovementTiming}) {
        CertifiedLoop out{.structure = structure.name,
                          .axis = axis,
                          .by_sticks = timing.by_sticks,
                          .box = structure.box[axis == Axis::kX ? 0 : 1],
                          .sampled = sampled,
                          .why_not = ""};
        EnclosedLoop loop(believed, structure, axis, timing);
        out.holds = Proof(loop, attitude_of(structure.vehicle, axis).natural_frequency_rad_s,
                          kDelayTick_s * static_cast<double>(timing.command_ticks), margin, out)
                        .run();
        progress(out);
        all.push_back(std::move(out));
      }
    }
  }
  return all;
}

}  // namespace m100::lab::gains
