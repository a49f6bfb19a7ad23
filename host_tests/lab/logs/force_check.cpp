// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/force_check.h"

#include <array>
#include <cmath>

#include "host_tests/lab/printed.h"

namespace m100::lab::logs {
namespace {

constexpr double kMin_s = 5.0;  // accelerations average out
constexpr double kHalf = 0.5;   // between an effect that is absent and one that is there
constexpr double kSharedVariance = 0.5;

/// Regression of a force on the same component of the thrust's direction in the world.
struct Regression {
  double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
  void add(double direction, double force) {
    n += 1;
    x += direction;
    y += force;
    xx += direction * direction;
    yy += force * force;
    xy += direction * force;
  }
  /// @param size  the force along the thrust
  bool follows(double size) const {
    const double own = xx - x * x / n;
    const double other = yy - y * y / n;
    const double both = xy - x * y / n;
    return own > 0.0 && other > 0.0 && both > kHalf * size * own && both * both > kSharedVariance * own * other;
  }
};

void leave_out(FlightLog& log, const std::string& why) {
  for (int i = 0; i < 3; ++i) {
    const Signal part = offset(Signal::kForceX, i);
    log.of(part).clear();
    log.signal_gap.erase(part);
    log.row_s.erase(part);
  }
  log.notes.push_back("force_x, force_y, force_z: " + why + "; they are left out");
}

}  // namespace

void validate_force(FlightLog& log) {
  if (!log.has3(Signal::kForceX)) {
    return;
  }
  const std::vector<std::uint8_t> gap = log.gap_of({Signal::kForceX, Signal::kForceY, Signal::kForceZ});
  const bool tilts = log.has3(Signal::kAttitudeRoll);
  std::array<double, 3> mean{};
  double square = 0.0;
  std::array<Regression, 2> tilt;
  std::size_t count = 0;
  for (std::size_t k = 0; k < log.size; ++k) {
    if (k < gap.size() && gap[k] != 0) {
      continue;
    }
    ++count;
    for (int i = 0; i < 3; ++i) {
      const double force = log.of(offset(Signal::kForceX, i))[k];
      mean[static_cast<std::size_t>(i)] += force;
      square += force * force;
    }
    if (tilts) {
      const double roll = log.of(Signal::kAttitudeRoll)[k];
      const double pitch = log.of(Signal::kAttitudePitch)[k];
      const double yaw = log.of(Signal::kAttitudeYaw)[k];
      const double forward = std::sin(pitch) * std::cos(roll);
      tilt[0].add(forward * std::cos(yaw) + std::sin(roll) * std::sin(yaw), log.of(Signal::kForceX)[k]);
      tilt[1].add(forward * std::sin(yaw) - std::sin(roll) * std::cos(yaw), log.of(Signal::kForceY)[k]);
    }
  }
  if (static_cast<double>(count) * log.period_s < kMin_s) {
    return;
  }
  const double size = std::hypot(mean[0], mean[1], mean[2]) / static_cast<double>(count);
  const double rms = std::sqrt(square / static_cast<double>(count));
  if (size < kHalf * rms) {
    leave_out(log,
              printed("the mean is %.2f m/s^2, where a specific force has 9.81: gravity was subtracted from it", size));
  } else if (tilt[0].follows(size) && tilt[1].follows(size)) {
    leave_out(log, "the horizontal parts follow the tilt: they are in world axes, not in the body's");
  }
}

}  // namespace m100::lab::logs
