// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/excite/pieces.h"

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string_view>

#include "firmware/companion/files/text/suggestion.h"

namespace m100::lab::excite {
namespace {

Piece doublet(double half_s) {
  return {2 * half_s, [half_s](double t) { return t < half_s ? 1.0 : -1.0; }, {}};
}
Piece steps_3211(double unit_s) {
  return {7 * unit_s,
          [unit_s](double t) {
            return t < 3 * unit_s ? 1.0 : t < 5 * unit_s ? -1.0 : t < 6 * unit_s ? 1.0 : -1.0;
          },
          {}};
}
Piece chirp(double from_hz, double to_hz, double length_s) {
  const double rise = (to_hz - from_hz) / length_s;
  std::vector<double> breaks_s;
  for (double turns = 0.5;; turns += 0.5) {  // from t + rise t^2 / 2 = turns
    const double at_s = (-from_hz + std::sqrt(from_hz * from_hz + 2.0 * rise * turns)) / rise;
    if (at_s >= length_s) {
      break;
    }
    breaks_s.push_back(at_s);
  }
  return {length_s, [=](double t) { return std::sin(2 * std::numbers::pi * (from_hz * t + 0.5 * rise * t * t)); },
          breaks_s};
}
/// A small and slow movement through the dead zone, which shows dead zone, trim and hysteresis.
Piece sweep(double length_s) {
  return {length_s, [=](double t) { return 0.3 * std::sin(2 * std::numbers::pi * t / length_s); }, {0.5 * length_s}};
}

/// A slow ramp through neutral, to either side (paper, III-B.5), up to `share` of the amplitude. It is slow because a
/// command lasts 40 ms: at 45 counts/s an edge of the dead zone is known to 1.8 counts at best.
Piece ramp(double length_s, double share) {
  return {length_s,
          [=](double t) {
            const double turn = t / length_s;
            return share * (turn < 0.25 ? 4.0 * turn : turn < 0.75 ? 2.0 - 4.0 * turn : 4.0 * turn - 4.0);
          },
          {0.5 * length_s}};
}

}  // namespace

std::vector<Piece> pieces(const std::string& kind) {
  if (kind == "doublet") {
    return {doublet(0.4), doublet(0.7), doublet(1.1)};
  }
  if (kind == "3211") {
    return {steps_3211(0.25), steps_3211(0.4)};
  }
  if (kind == "chirp") {
    return {chirp(0.3, 2.5, 8.0)};
  }
  if (kind == "mixed") {
    return {doublet(0.6), steps_3211(0.3), sweep(4.0), chirp(0.4, 2.0, 6.0), doublet(1.0), steps_3211(0.2)};
  }
  if (kind == "sweep") {  // without the dynamics, which the doublets show, an edge looks like a delay
    return {doublet(0.6), ramp(8.0, 0.6), doublet(0.35), ramp(8.0, 0.25)};
  }
  constexpr std::array<std::string_view, 5> kKinds{"doublet", "3211", "chirp", "mixed", "sweep"};
  throw std::invalid_argument("--kind: '" + kind + "': must be doublet, 3211, chirp, mixed or sweep" +
                              companion::did_you_mean(kind, kKinds));
}

}  // namespace m100::lab::excite
