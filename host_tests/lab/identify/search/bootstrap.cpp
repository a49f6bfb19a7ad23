// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/search/bootstrap.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace m100::lab::identify {

std::vector<Interval> bootstrap(const Family& family, const Fit& fit, const Coordinates& coordinates, std::size_t draws,
                                std::uint64_t seed) {
  const std::size_t blocks = family.block_count();
  std::mt19937_64 random(seed);
  const std::vector<double> values = coordinates(fit);
  std::vector<std::vector<double>> samples(values.size());
  for (std::size_t draw = 0; draw < draws; ++draw) {
    std::vector<int> weights(blocks, 0);
    for (std::size_t i = 0; i < blocks; ++i) {
      ++weights[static_cast<std::size_t>(random() % blocks)];
    }
    const std::vector<double> drawn = coordinates(family.fit(fit.structure, weights, &fit));
    for (std::size_t k = 0; k < samples.size(); ++k) {
      samples[k].push_back(drawn[k]);
    }
  }
  // A percentile interval of few blocks is too narrow: the spread of n blocks is known with n - 1 degrees of freedom
  // only (Student's t at 97.5 % over the normal quantile, t by the first terms of its expansion in 1 / (n - 1)).
  const double degrees = std::max(2.0, static_cast<double>(blocks) - 1.0);
  const double widening = std::sqrt((degrees + 1.0) / degrees) * (1.0 + 1.21 / degrees + 1.45 / (degrees * degrees));
  std::vector<Interval> out(samples.size());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double value = values[k];
    out[k] = {value, value, value};
    if (samples[k].empty()) {
      continue;
    }
    std::sort(samples[k].begin(), samples[k].end());
    const auto quantile = [&](double fraction) {
      const double at = fraction * static_cast<double>(samples[k].size() - 1);
      const auto lower = static_cast<std::size_t>(at);
      const std::size_t upper = std::min(lower + 1, samples[k].size() - 1);
      return samples[k][lower] + (at - std::floor(at)) * (samples[k][upper] - samples[k][lower]);
    };
    out[k].low = std::min(value, value + widening * (quantile(0.025) - value));
    out[k].high = std::max(value, value + widening * (quantile(0.975) - value));
  }
  return out;
}

}  // namespace m100::lab::identify
