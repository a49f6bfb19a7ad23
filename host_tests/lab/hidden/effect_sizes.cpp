// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/hidden/effect_sizes.h"

#include "host_tests/lab/hidden/random_source.h"

namespace m100::lab::hidden {
namespace {

struct Sizes {
  double small, medium, large;
  enum class Sign { kPlus, kBoth, kAboutOne } sign;
};

const std::map<std::string, Sizes>& sizes() {
  using enum Sizes::Sign;
  static const std::map<std::string, Sizes> kSizes{{"transport_delay", {0.06, 0.10, 0.15, kPlus}},
                                                   {"lead_zero", {0.08, 0.13, 0.20, kPlus}},
                                                   {"dead_zone", {10, 20, 32, kPlus}},
                                                   {"saturation", {0.22, 0.18, 0.14, kPlus}},
                                                   {"tilt_limit", {0.24, 0.20, 0.16, kPlus}},
                                                   {"rate_limit", {1.2, 0.9, 0.65, kPlus}},
                                                   {"gain_asymmetry", {0.12, 0.25, 0.40, kAboutOne}},
                                                   {"trim_offset", {15, 40, 70, kBoth}},
                                                   {"stick_curve", {1.15, 1.35, 1.6, kPlus}},
                                                   {"backlash", {9, 18, 28, kPlus}},
                                                   {"gain_drift", {0.15, 0.28, 0.45, kBoth}},
                                                   {"cross_axis", {0.08, 0.17, 0.28, kBoth}},
                                                   {"steady_wind", {0.15, 0.4, 0.9, kPlus}},
                                                   {"body_bias", {0.15, 0.4, 0.9, kPlus}},
                                                   {"linear_drag", {0.08, 0.22, 0.45, kPlus}},
                                                   {"body_drag", {0.1, 0.25, 0.5, kPlus}},
                                                   {"quadratic_drag", {0.03, 0.08, 0.16, kPlus}},
                                                   {"tilt_gain", {0.06, 0.13, 0.22, kAboutOne}},
                                                   {"thrust_gain", {0.03, 0.08, 0.15, kAboutOne}},
                                                   {"thrust_lag", {0.04, 0.08, 0.15, kPlus}},
                                                   {"axial_inflow", {0.12, 0.3, 0.6, kPlus}},
                                                   {"time_offset", {0.03, 0.06, 0.10, kBoth}},
                                                   {"yaw_misalignment", {0.06, 0.13, 0.22, kBoth}},
                                                   {"periodic_wind", {0.15, 0.4, 0.8, kPlus}},
                                                   {"sine", {0.012, 0.02, 0.035, kPlus}},
                                                   {"slung_load", {0.1, 0.2, 0.35, kPlus}},
                                                   {"dropout", {0.3, 0.5, 0.8, kPlus}},
                                                   {"product", {0.5, 1.0, 1.8, kPlus}}};
  return kSizes;
}

}  // namespace

bool supports_effect(const std::string& effect) { return sizes().count(effect) > 0; }

double size_of(const std::string& effect, int size, std::uint64_t seed) {
  const Sizes& known = sizes().at(effect);
  RandomSource rng(seed ^ 0xABCDEFULL);
  const double base = (size == 0 ? known.small : size == 1 ? known.medium : known.large) * rng.between(0.85, 1.15);
  const bool minus = rng.between(0.0, 1.0) < 0.5;
  if (known.sign == Sizes::Sign::kAboutOne) {
    return minus ? 1.0 / (1.0 + base) : 1.0 + base;
  }
  return known.sign == Sizes::Sign::kBoth && minus ? -base : base;
}

}  // namespace m100::lab::hidden
