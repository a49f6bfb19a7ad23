// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <vector>

#include "host_tests/lab/gains/complex_number.h"
#include "host_tests/lab/gains/margins.h"

namespace m100::lab::gains {

inline constexpr double kLoopTick_s = 0.01;

/// One horizontal axis of second order, about hover, of gain 1:
///   tilt = w^2 (1 + lead s) / (s^2 + 2 damping w s + w^2) u(t - delay),   position = pull / (s (s + drag)) tilt.
/// The delay is the sum of `delay_ticks` ticks of 10 ms and `rest_s`, 0 to 10 ms.
template <typename R>
struct PlantParameters {
  R frequency_rad_s{};
  R damping{};
  R rest_s{};
  double lead_s = 0.0;
  double drag_per_s = 0.0;
  double pull_m_s2 = 0.0;
  int delay_ticks = 0;
};

/// (1 - e^-ct) / c for order 1, its integral over t for order 2. The series holds at c = 0 too. @pre 0 <= c t <= 0.5:
/// its relative error is below 2e-13, and below 1e-16 up to c t = 0.25
template <typename R>
R decay_integral(const R& t, double c, int order) {
  R nested(1.0);
  for (int k = 12; k > order; --k) {
    nested = R(1.0) - R(c / static_cast<double>(k)) * t * nested;
  }
  return order == 1 ? t * nested : R(0.5) * t * t * nested;
}

/// z^periods. @param inverse  1 / z
template <typename R>
ComplexNumber<R> power(const ComplexNumber<R>& z, const ComplexNumber<R>& inverse, int periods) {
  if (periods == 0) {
    return {R(1.0), R(0.0)};
  }
  const ComplexNumber<R>& factor = periods > 0 ? z : inverse;
  ComplexNumber<R> out = factor;
  for (int k = 1; k < std::abs(periods); ++k) {
    out = out * factor;
  }
  return out;
}

/// Transition matrix over a time. States: position, velocity, the second-order system's state and its derivative.
template <typename R>
using PlantMatrix = std::array<std::array<R, 4>, 4>;

/// Power series in time of two impulse responses: h of 1 / (s^2 + a1 s + a0) and v of pull (1 + lead s) / ((s + drag)
/// (s^2 + a1 s + a0)), with their integrals. The truncation error is below 1e-16 for natural frequencies to 12 rad/s
/// and below 1e-13 to 20 rad/s.
template <typename R>
class PlantSeries {
 public:
  PlantSeries(const PlantParameters<R>& plant, const R& a0, const R& a1) {
    h_[0] = R(0.0), h_[1] = R(1.0), v_[0] = R(0.0);
    for (std::size_t n = 0; n < kTerms; ++n) {
      const auto next = static_cast<double>(n + 1);
      if (n > 0) {
        h_[n + 1] = R(-1.0 / next) * (a1 * h_[n] + R(1.0 / static_cast<double>(n)) * (a0 * h_[n - 1]));
      }
      v_[n + 1] = R(plant.pull_m_s2 / next) * h_[n] + R(plant.pull_m_s2 * plant.lead_s) * h_[n + 1] -
                  R(plant.drag_per_s / next) * v_[n];
    }
  }
  struct At {
    R h, h_integral, v, v_integral, v_integral2;
  };
  /// @param t [s] 0 to 0.01
  At at(const R& t) const {
    At out{};
    for (std::size_t n = kTerms + 1; n-- > 0;) {
      const double by = 1.0 / static_cast<double>(n + 1);
      out.h = h_[n] + t * out.h;
      out.h_integral = R(by) * h_[n] + t * out.h_integral;
      out.v = v_[n] + t * out.v;
      out.v_integral = R(by) * v_[n] + t * out.v_integral;
      out.v_integral2 = R(by / static_cast<double>(n + 2)) * v_[n] + t * out.v_integral2;
    }
    out.h_integral = t * out.h_integral;
    out.v_integral = t * out.v_integral;
    out.v_integral2 = t * t * out.v_integral2;
    return out;
  }

 private:
  static constexpr std::size_t kTerms = 12;
  std::array<R, kTerms + 1> h_{}, v_{};  ///< by power of the time
};

/// The vehicle from tick to tick, x(k+1) = A x + early u(k-n-1) + late u(k-n), at commands z^k that each hold for one
/// period.
template <typename R>
struct SampledPlant {
  using C = ComplexNumber<R>;
  using State = std::array<C, 4>;
  PlantMatrix<R> step;
  std::array<R, 4> early, late;
  int ticks = 1;
  int delay_ticks = 0;
  C z, inverse;

  SampledPlant(const PlantParameters<R>& plant, const R& a0, const R& a1, const C& at, int period_ticks)
      : ticks(period_ticks), delay_ticks(plant.delay_ticks), z(at), inverse(C{R(1.0), R(0.0)} / at) {
    const PlantSeries<R> series(plant, a0, a1);
    const R tick(kLoopTick_s), pull(plant.pull_m_s2);
    const auto whole = series.at(tick), rest = series.at(tick - plant.rest_s);
    const R free1 = decay_integral(tick, plant.drag_per_s, 1), free2 = decay_integral(tick, plant.drag_per_s, 2);
    const std::array<R, 4> forced{a0 * whole.v_integral2, a0 * whole.v_integral, a0 * whole.h_integral, a0 * whole.h};
    late = {a0 * rest.v_integral2, a0 * rest.v_integral, a0 * rest.h_integral, a0 * rest.h};
    for (std::size_t i = 0; i < 4; ++i) {
      early[i] = forced[i] - late[i];
    }
    step[0] = {R(1.0), free1, pull * free2 - forced[0], whole.v_integral};
    step[1] = {R(0.0), R(1.0) - R(plant.drag_per_s) * free1, pull * free1 - forced[1], whole.v};
    step[2] = {R(0.0), R(0.0), R(1.0) - forced[2], whole.h};
    step[3] = {R(0.0), R(0.0), R(0.0) - forced[3], R(1.0) - a1 * whole.h - a0 * whole.h_integral};
  }
  int period_of(int tick) const { return tick >= 0 ? tick / ticks : -((ticks - 1 - tick) / ticks); }
  C command(int tick) const { return power(z, inverse, period_of(tick - delay_ticks)); }

  /// @param integrators what position and velocity are multiplied by
  State after(const State& from, int tick, const C& integrators) const {
    const C first = command(tick - 1), second = command(tick);
    std::array<C, 4> driven;
    for (std::size_t i = 0; i < 4; ++i) {
      driven[i] = step[i][2] * from[2] + step[i][3] * from[3] + early[i] * first + late[i] * second;
    }
    return {from[0] + step[0][1] * from[1] + integrators * driven[0], step[1][1] * from[1] + integrators * driven[1],
            driven[2], driven[3]};
  }
  PlantMatrix<R> after_step(const PlantMatrix<R>& from) const {
    PlantMatrix<R> out{};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i < 2 ? i : 2; j < 4; ++j) {  // the others are 0
        for (std::size_t k = 0; k < 4; ++k) {
          out[i][j] = out[i][j] + step[i][k] * from[k][j];
        }
      }
    }
    return out;
  }
  /// The steady state at the start of a period. Its position and velocity are multiplied by `integrators`, an output.
  State start(C& integrators) const {
    const C one{R(1.0), R(0.0)};
    State forced{};
    PlantMatrix<R> period = step;
    for (int tick = 0; tick < ticks; ++tick) {
      forced = after(forced, tick, one);
      period = tick > 0 ? after_step(period) : period;
    }
    const C slow = one - inverse, slow_drag = one - period[1][1] * inverse;
    integrators = slow * slow_drag;
    const C z_tilt = z - period[2][2] * one, z_rate = z - period[3][3] * one;
    const C determinant = z_tilt * z_rate - (period[2][3] * period[3][2]) * one;
    State out;
    out[2] = (z_rate * forced[2] + period[2][3] * forced[3]) / determinant;
    out[3] = (period[3][2] * forced[2] + z_tilt * forced[3]) / determinant;
    const C to_position = forced[0] + period[0][2] * out[2] + period[0][3] * out[3];
    const C to_velocity = inverse * (forced[1] + period[1][2] * out[2] + period[1][3] * out[3]);
    out[0] = inverse * (slow_drag * to_position + period[0][1] * to_velocity);
    out[1] = slow * to_velocity;
    return out;
  }
};

/// The response of position, tilt and rate, sampled as they arrive in the ticks of one command period P, to commands
/// z^k that each hold for one period: out[3 i + 0, 1, 2] for tick i. The position is multiplied by the returned (1 -
/// 1/z) (1 - exp(-drag P)/z), so that nothing is divided by 0 at z = 1.
/// @param pose_age_ticks true age of the position
template <typename R>
ComplexNumber<R> plant_response(const PlantParameters<R>& plant, const ComplexNumber<R>& z, const LoopTiming& timing,
                                int pose_age_ticks, std::vector<ComplexNumber<R>>& out) {
  const int ticks = static_cast<int>(timing.command_ticks);
  const R a0 = square(plant.frequency_rad_s), a1 = R(2.0) * plant.damping * plant.frequency_rad_s, lead(plant.lead_s);
  const SampledPlant<R> sampled(plant, a0, a1, z, ticks);
  ComplexNumber<R> integrators;
  std::vector<typename SampledPlant<R>::State> states{sampled.start(integrators)};
  for (int tick = 0; tick + 1 < ticks; ++tick) {
    states.push_back(sampled.after(states.back(), tick, integrators));
  }
  out.resize(3 * timing.command_ticks);
  for (int tick = 0; tick < ticks; ++tick) {
    const auto at = [&](int seen, std::size_t k) {
      const int period = sampled.period_of(seen);
      return power(z, sampled.inverse, period) * states[static_cast<std::size_t>(seen - ticks * period)][k];
    };
    const int seen = tick - static_cast<int>(timing.attitude_age_ticks);
    const ComplexNumber<R> tilt = at(seen, 2), rate = at(seen, 3);
    const auto into = 3 * static_cast<std::size_t>(tick);
    out[into] = at(tick - pose_age_ticks, 0);
    out[into + 1] = tilt + lead * rate;
    out[into + 2] = (R(1.0) - lead * a1) * rate + (lead * a0) * (sampled.command(seen - 1) - tilt);
  }
  return integrators;
}

}  // namespace m100::lab::gains
