// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/sim/world/plant.h"
#include "host_tests/sim/world/random.h"

namespace m100::sim {

/// The velocity of the air at the aircraft, world frame: mean, plus a sine gust along it, plus turbulence.
///
/// Turbulence is Dryden's longitudinal form on all three axes: white noise through 1 / (1 + s L / V), variance as
/// stated, L the correlation length, V the mean speed but at least 1 m/s.
class Wind {
 public:
  Wind(const Air& air, std::uint64_t seed);
  /// Advances time. @returns the air's velocity at the end of the step.
  core::Vector<double, 3> advance(double step_s);
  /// Changes the parameters of the air; the turbulence continues from its present state.
  void set_parameters(const Air& air);

 private:
  Air air_;
  Random random_;
  core::Vector<double, 3> direction_;
  ColouredNoise x_;
  ColouredNoise y_;
  ColouredNoise z_;
  double time_s_ = 0.0;
};

}  // namespace m100::sim
