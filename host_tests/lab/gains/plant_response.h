// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "host_tests/lab/gains/complex_number.h"
#include "host_tests/lab/gains/margins.h"

namespace m100::lab::gains {

/// One horizontal axis of second order, about hover, of gain 1:
///   tilt = w^2 (1 + lead s) / (s^2 + 2 damping w s + w^2) u(t - delay),   position = pull / (s (s + drag)) tilt.
/// The delay is `delay_ticks` of 10 ms and `rest_s`, 0 to 10 ms.
template <typename R>
struct PlantParameters {
  R frequency_rad_s{};
  R damping{};
  R rest_s{};
  double lead_s = 0.0;
  double drag_per_s = 0.0;
  double pull_m_s2 = 0.0;
  int delay_ticks = 0;
  bool overdamped = false;  ///< damping above 1: two real poles
};

/// (1 - e^-ct) / c and (t - that) / c by their series, which hold at c = 0 too. @pre 0 <= c t < 0.5
/// @param size bound of the absolute remainder, as a fraction of the last term: by twelve terms, below 1e-16
template <typename R>
R decay_integral(const R& t, double c, int order) {
  // order 1: t - c t^2 / 2! + c^2 t^3 / 3! - ...; order 2: t^2 / 2! - c t^3 / 3! + ...
  R term = order == 1 ? t : R(0.5) * t * t;
  R sum = term;
  for (int k = order + 1; k < order + 12; ++k) {
    term = R(-c / static_cast<double>(k)) * t * term;
    sum = sum + term;
  }
  return sum;
}

/// z^periods. @param inverse  1 / z
template <typename R>
ComplexNumber<R> power(const ComplexNumber<R>& z, const ComplexNumber<R>& inverse, int periods) {
  ComplexNumber<R> out{R(1.0), R(0.0)};
  for (int k = 0; k < periods; ++k) {
    out = out * z;
  }
  for (int k = 0; k > periods; --k) {
    out = out * inverse;
  }
  return out;
}

/// The response of position, tilt and rate, sampled as they arrive in the ticks of one command period, to commands z^k
/// that each hold for one period: out[3 i + 0, 1, 2] for tick i. The position is multiplied by the returned (1 - 1/z)
/// (1 - exp(-drag P)/z), so that nothing is divided by 0 at z = 1. Closed form, in exact arithmetic. In terms of the
/// step response s of each quantity, y(t) = (1 - 1/z) z^k0 sum over n >= 0 of z^-n s(t' + n P), with t' in [0, P] the
/// time since the newest command that acts; s consists of exponentials, whose sums are geometric. At t' = 0 the newest
/// command has just begun to act and at t' = P it is about to: both limits of a rate that jumps are in the closed
/// range.
/// @param pose_age_ticks true age of the position
// Deviation: one formula, in the order in which its sums are derived above.
template <typename R>
ComplexNumber<R> plant_response(const PlantParameters<R>& plant, const ComplexNumber<R>& z, const LoopTiming& timing,
                                int pose_age_ticks, std::vector<ComplexNumber<R>>& out) {
  using std::sqrt;
  using C = ComplexNumber<R>;
  const int ticks = static_cast<int>(timing.command_ticks);
  const double period_s = 0.01 * ticks;
  const C one{R(1.0), R(0.0)};
  const C inverse = one / z;
  const R& w = plant.frequency_rad_s;
  const R& damping = plant.damping;
  const double c = plant.drag_per_s;
  // Both poles, their residues in the step response of the tilt, and what the position's two integrations make of them.
  const R root = w * sqrt(plant.overdamped ? square(damping) - R(1.0) : R(1.0) - square(damping));
  const R middle = R(0.0) - damping * w;
  const C pole = plant.overdamped ? C{middle + root, R(0.0)} : C{middle, root};
  const C other = plant.overdamped ? C{middle - root, R(0.0)} : conjugate(pole);
  const auto residue_of = [&](const C& p, const C& q) {
    return C{square(w), R(0.0)} * (one + R(plant.lead_s) * p) / (p * (p - q));
  };
  const auto position_of = [&](const C& of, const C& p) { return of / (p * (p + C{R(c), R(0.0)})); };
  const C residue = residue_of(pole, other), other_residue = residue_of(other, pole);
  const C position_residue = position_of(residue, pole), other_position_residue = position_of(other_residue, other);
  const C slow = one - inverse;                                    // a
  const C slow_drag = one - R(std::exp(-c * period_s)) * inverse;  // b
  const C fast = one / (one - exponential(R(period_s) * pole) * inverse);
  const C other_fast = one / (one - exponential(R(period_s) * other) * inverse);
  const R period = R(period_s);
  const R whole1 = decay_integral(period, c, 1), whole2 = decay_integral(period, c, 2);
  // Slow part of the position's step response: F0 + late (E0 - Ec) / c + later Ec.
  const R late = R(plant.lead_s) - R(2.0) * damping / w;
  const R denominator = square(w) - R(2.0 * c) * damping * w + R(c * c);
  const R later = (late * (R(c) - R(2.0) * damping * w) - R(1.0)) / denominator;

  out.resize(static_cast<std::size_t>(3 * ticks));
  const auto begun = [&](int age, int tick, int& period_index) {  // t' at a tick
    const int since = tick - age - plant.delay_ticks;
    period_index = since > 0 ? (since + ticks - 1) / ticks - 1 : -((-since) / ticks) - 1;
    return R(0.01 * (since - ticks * period_index)) - plant.rest_s;
  };
  for (int tick = 0; tick < ticks; ++tick) {
    int index = 0;
    const R t = begun(pose_age_ticks, tick, index);
    const R part1 = decay_integral(t, c, 1), part2 = decay_integral(t, c, 2);
    // Each quotient of the geometric sums, times slow slow_drag.
    const C rigid =
        slow * (C{part2, R(0.0)} + (whole2 - part2 + t * whole1) * inverse) + (period * whole1) * (inverse * inverse);
    const C once = slow * (C{part1, R(0.0)} + (whole1 - part1) * inverse);
    const C decayed = (R(1.0) - R(c) * part1) * (slow * slow);
    const C modes =
        position_residue * exponential(t * pole) * fast + other_position_residue * exponential(t * other) * other_fast;
    const auto at = static_cast<std::size_t>(3 * tick);
    out[at] = R(plant.pull_m_s2) *
              (power(z, inverse, index) * (rigid + late * once + later * decayed + slow * slow * slow_drag * modes));

    const R turned = begun(static_cast<int>(timing.attitude_age_ticks), tick, index);
    const C mode = residue * exponential(turned * pole) * fast;
    const C other_mode = other_residue * exponential(turned * other) * other_fast;
    const C factor = power(z, inverse, index);
    out[at + 1] = factor * (one + slow * (mode + other_mode));
    out[at + 2] = factor * (slow * (pole * mode + other * other_mode));
  }
  return slow * slow_drag;
}

}  // namespace m100::lab::gains
