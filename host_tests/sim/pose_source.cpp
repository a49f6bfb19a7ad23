// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/pose_source.h"

#include <cmath>

namespace m100::sim {
namespace {

core::Duration duration_of(double seconds) { return core::Duration(std::llround(seconds * 1e6)); }

}  // namespace

void PoseSource::capture(core::TimePoint now, const VehicleState& truth, double yaw_rad) {
  PoseSample sample{.captured = now, .position_w_m = truth.position_w_m, .yaw_rad = yaw_rad};
  for (Eigen::Index i = 0; i < 3; ++i) {
    sample.position_w_m[i] += sensors_.pose_noise_m * random_.normal();
  }
  sample.yaw_rad += sensors_.pose_yaw_noise_rad * random_.normal();
  const bool drops = random_.uniform() < sensors_.pose_dropout_per_s * core::seconds<double>(kPeriod);
  const double jitter = random_.uniform();
  if (drops) {
    back_ = now + duration_of(sensors_.pose_dropout_s);
  }
  if (!faults_.frozen) {
    frozen_.reset();
  } else if (!frozen_) {
    frozen_ = sample;
  }
  if (frozen_) {
    sample.position_w_m = frozen_->position_w_m;
    sample.yaw_rad = frozen_->yaw_rad;
  }
  const double c = std::cos(faults_.turn_rad);
  const double s = std::sin(faults_.turn_rad);
  const core::Vector<double, 3> straight = sample.position_w_m;
  sample.position_w_m = {c * straight.x() - s * straight.y(), s * straight.x() + c * straight.y(), straight.z()};
  sample.position_w_m += faults_.jump_m;
  sample.yaw_rad = std::remainder(sample.yaw_rad + faults_.turn_rad, 2.0 * core::kPi);
  if (faults_.not_finite) {
    sample.position_w_m.x() = std::numeric_limits<double>::quiet_NaN();
  }
  if (now < back_ || faults_.silent) {
    return;
  }
  const core::Duration late(static_cast<core::Duration::rep>(jitter * static_cast<double>(faults_.jitter.count())));
  air_.push_back({now + duration_of(sensors_.pose_delay_s) + faults_.extra_delay + late, sample});
}

std::optional<PoseSample> PoseSource::step(core::TimePoint now, const VehicleState& truth, double yaw_rad) {
  if (now >= next_) {
    capture(now, truth, yaw_rad);
    next_ = now + kPeriod;
  }
  if (air_.empty() || air_.front().arrival > now) {
    return std::nullopt;
  }
  const PoseSample arrived = air_.front().sample;
  air_.pop_front();
  return arrived;
}

}  // namespace m100::sim
