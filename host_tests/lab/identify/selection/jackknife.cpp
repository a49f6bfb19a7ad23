// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/selection/jackknife.h"

#include <algorithm>
#include <cmath>

namespace m100::lab::identify {
namespace {

/// 97.5 % quantile of Student's t, by the first terms of its expansion about the normal one (Abramowitz and Stegun
/// 26.7.5): 1 % too small for three degrees of freedom, less for more, 24 % for one.
double student_t(double degrees) { return 1.959964 + (2.3723 + (2.8225 + 2.5559 / degrees) / degrees) / degrees; }

}  // namespace

std::vector<Interval> jackknife(const Family& family, const Fit& fit, const Coordinates& coordinates,
                                std::size_t refits) {
  const std::size_t blocks = family.block_count();
  const std::vector<double> values = coordinates(fit);
  std::vector<Interval> out(values.size());
  std::transform(values.begin(), values.end(), out.begin(), [](double value) { return Interval{value, value, value}; });
  const std::size_t groups = std::min({blocks, refits, kMaxRefits});
  if (groups < 2) {
    return out;
  }
  std::vector<double> sums(values.size(), 0.0);
  std::vector<double> squares(values.size(), 0.0);
  for (std::size_t group = 0; group < groups; ++group) {
    std::vector<int> weights(blocks, 1);
    std::fill(weights.begin() + static_cast<std::ptrdiff_t>(group * blocks / groups),
              weights.begin() + static_cast<std::ptrdiff_t>((group + 1) * blocks / groups), 0);
    const std::vector<double> without = coordinates(family.fit(fit.structure, weights, &fit));
    for (std::size_t k = 0; k < values.size(); ++k) {
      sums[k] += without[k] - values[k];
      squares[k] += (without[k] - values[k]) * (without[k] - values[k]);
    }
  }
  const double n = static_cast<double>(groups);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double variance = (n - 1.0) / n * std::max(0.0, squares[k] - sums[k] * sums[k] / n);
    const double half_width = student_t(n - 1.0) * std::sqrt(variance);
    out[k].low = values[k] - half_width;
    out[k].high = values[k] + half_width;
  }
  return out;
}

}  // namespace m100::lab::identify
