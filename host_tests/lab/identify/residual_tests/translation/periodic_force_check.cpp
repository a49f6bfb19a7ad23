// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/translation/periodic_force_check.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "host_tests/lab/identify/model/translation/coordinate_search.h"
#include "host_tests/lab/identify/residual_tests/periodic_force.h"

namespace m100::lab::identify::translation {
namespace {

constexpr double kPredictedShare = 0.5;

bool stays_in_phase(const Family& family, const Fit& fit, const std::string& name) {
  const std::size_t blocks = family.block_count();
  const std::size_t fitted = (3 * blocks) / 5;
  std::vector<int> early(blocks, 0);
  std::fill_n(early.begin(), fitted, 1);
  std::vector<int> late(blocks, 1);
  std::fill_n(late.begin(), fitted, 0);
  const auto sum_of = [&](const Fit& one) {
    double sum = 0.0;
    for (const std::vector<double>& block : family.errors(one, late)) {
      sum = std::inner_product(block.begin(), block.end(), block.begin(), sum);
    }
    return sum;
  };
  const Structure rest = family.without(fit.structure, name);
  const std::vector<int> all(blocks, 1);
  const double without_line = sum_of(family.fit(rest, all, nullptr));
  const double with_line = sum_of(fit);
  const double foretold = sum_of(family.fit(fit.structure, early, &fit));
  return without_line - foretold > kPredictedShare * (without_line - with_line);
}

/// The fit without the effect's columns, not fitted again.
Fit without_sinusoid(const Fit& fit, const std::string& name) {
  Fit plain = fit;
  const auto first = static_cast<std::ptrdiff_t>(kSearched + column_of(fit.structure, name));
  const auto count = static_cast<std::ptrdiff_t>(linear_count(fit.structure, name));
  plain.structure.erase(std::find(plain.structure.begin(), plain.structure.end(), name));
  plain.parameters.erase(plain.parameters.begin() + first, plain.parameters.begin() + first + count);
  return plain;
}

bool vehicle_moves_at_frequency(const TranslationBlocks& training, const Fit& fit,
                                const model::TranslationEffect& effect) {
  const std::string name(effect.name);
  const std::span<const double> linear = linear_of(fit, name);
  const Vector left = residual_of(training, measured_rows(training), without_sinusoid(fit, name));
  VehicleMotion motion{
      .frequency_hz = fit.parameters[slot_of(effect)], .force = {}, .residual = {}, .channels = {}, .speed_m_s = {}};
  for (std::size_t n = 0; n < 2; ++n) {
    motion.force[n] = {linear[2 * n], linear[2 * n + 1]};
    motion.residual[n] = axis_series(training, left, n, {});
  }
  const TranslationData& data = *training.data;
  const auto channel = [&](const char* called, const std::vector<double>& values, int moved_by) {
    motion.channels.push_back({.name = called, .moved_by_axis = moved_by, .values = {}});
    for (const auto& block : training.blocks) {
      for (const std::size_t i : block.samples) {
        motion.channels.back().values.push_back(values[i]);
      }
    }
  };
  if (data.has_velocity) {
    channel("velocity_x", data.velocity[0], 0);
    channel("velocity_y", data.velocity[1], 1);
    channel("velocity_z", data.velocity[2], -1);
    for (const auto& block : training.blocks) {
      for (const std::size_t i : block.samples) {
        motion.speed_m_s.push_back(std::hypot(data.velocity[0][i], data.velocity[1][i], data.velocity[2][i]));
      }
    }
  }
  channel("tilt_x", data.direction[0], -1);
  channel("tilt_y", data.direction[1], -1);
  channel("thrust", data.thrust, -1);
  return !check_vehicle_motion(motion).empty();
}

}  // namespace

bool is_periodic_force(const Family& family, const TranslationBlocks& training, const Fit& fit,
                       const model::TranslationEffect& effect) {
  return !vehicle_moves_at_frequency(training, fit, effect) && stays_in_phase(family, fit, std::string(effect.name));
}

}  // namespace m100::lab::identify::translation
