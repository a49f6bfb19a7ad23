// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/world/wind.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace m100::sim {
namespace {

core::Vector<double, 3> direction_of(const Air& air) {
  return air.wind_m_s.norm() > 0.0 ? core::Vector<double, 3>(air.wind_m_s.normalized())
                                   : core::Vector<double, 3>(1.0, 0.0, 0.0);
}

double correlation_time_s(const Air& air) { return air.turbulence_length_m / std::max(1.0, air.wind_m_s.norm()); }

}  // namespace

Wind::Wind(const Air& air, std::uint64_t seed)
    : air_(air),
      random_(seed, "wind"),
      direction_(direction_of(air)),
      x_(air.turbulence_m_s, correlation_time_s(air)),
      y_(air.turbulence_m_s, correlation_time_s(air)),
      z_(air.turbulence_m_s, correlation_time_s(air)) {}

void Wind::set_parameters(const Air& air) {
  air_ = air;
  direction_ = direction_of(air);
  for (ColouredNoise* const axis : {&x_, &y_, &z_}) {
    axis->set_parameters(air.turbulence_m_s, correlation_time_s(air));
  }
}

core::Vector<double, 3> Wind::advance(double step_s) {
  time_s_ += step_s;
  const double gust_m_s = air_.gust_m_s * std::sin(2.0 * std::numbers::pi * air_.gust_hz * time_s_);
  const double x = x_.advance(step_s, random_);
  const double y = y_.advance(step_s, random_);
  const double z = z_.advance(step_s, random_);
  return air_.wind_m_s + gust_m_s * direction_ + core::Vector<double, 3>(x, y, z);
}

}  // namespace m100::sim
