// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/quaternion.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace m100::lab::logs {
namespace {

constexpr double kUnitWithin =
    0.1;  // 16-bit integers and rounded text are far closer; a wrong order of the parts is not detected

double dot(const Quaternion& a, const Quaternion& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]; }

}  // namespace

std::array<double, 3> euler_zyx(const Quaternion& q) {
  const double size = std::sqrt(dot(q, q));
  const double w = q[0] / size;
  const double x = q[1] / size;
  const double y = q[2] / size;
  const double z = q[3] / size;
  return {std::atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
          std::asin(std::clamp(2.0 * (w * y - z * x), -1.0, 1.0)),
          std::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))};
}

std::size_t make_continuous(std::array<std::vector<double>*, 4> parts) {
  Quaternion before{1.0, 0.0, 0.0, 0.0};
  std::size_t wrong = 0;
  for (std::size_t k = 0; k < parts[0]->size(); ++k) {
    Quaternion q{};
    for (std::size_t i = 0; i < 4; ++i) {
      q[i] = (*parts[i])[k];
    }
    const double size = std::sqrt(dot(q, q));
    const bool unit = std::isfinite(size) && std::abs(size - 1.0) < kUnitWithin;
    const double side = dot(q, before) < 0.0 ? -1.0 : 1.0;
    const double factor = unit ? side / size : std::numeric_limits<double>::quiet_NaN();
    wrong += unit ? 0U : 1U;
    for (std::size_t i = 0; i < 4; ++i) {
      (*parts[i])[k] = factor * q[i];
      before[i] = unit ? factor * q[i] : before[i];
    }
  }
  return wrong;
}

}  // namespace m100::lab::logs
