// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/world/pose_source.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace m100::sim {
namespace {

/// Of a locked source: it captures a quarter of a tick after our tick, if its rate is a multiple of ours.
constexpr double kLockedPhase_s = 0.0025;
/// Captures that are overdue by more than this are skipped: the caller has slept.
constexpr core::Duration kAsleep = std::chrono::milliseconds(100);

/// The sender's time when our clock showed zero.
constexpr core::SenderTime kOrigin{core::SenderClock::duration{1763757191000000}};

core::Duration duration_of(double seconds) { return core::Duration(std::llround(seconds * 1e6)); }

}  // namespace

PoseSource::PoseSource(const PoseNumbers& numbers, std::uint64_t seed)
    : numbers_(numbers), random_(seed, "pose"), network_(seed, "pose network") {
  phase_s_ =
      numbers_.phase == PosePhase::kRandom ? Random(seed, "pose phase").uniform() / numbers_.rate_hz : kLockedPhase_s;
  next_ = capture_time(0);
}

core::TimePoint PoseSource::capture_time(std::uint64_t number) const {
  const double own_s = phase_s_ + static_cast<double>(number) / numbers_.rate_hz;
  return core::TimePoint(duration_of(own_s / (1.0 + 1e-6 * numbers_.clock_drift_ppm)));
}

core::SenderTime PoseSource::own_time(core::TimePoint now) const {
  const double drifted_us = 1e-6 * numbers_.clock_drift_ppm * static_cast<double>(now.time_since_epoch().count());
  return kOrigin + core::SenderClock::duration(now.time_since_epoch().count() + std::llround(drifted_us));
}

core::TimePoint PoseSource::next_event() const { return air_.empty() ? next_ : std::min(next_, air_.front().arrival); }

core::TimePoint PoseSource::arrival_of(core::TimePoint captured, double jitter) {
  const core::Duration late(static_cast<core::Duration::rep>(jitter * static_cast<double>(faults_.jitter.count())));
  const core::Duration own = duration_of(numbers_.jitter_s > 0.0 ? numbers_.jitter_s * network_.uniform() : 0.0);
  const core::TimePoint arrival = captured + duration_of(numbers_.latency_s) + own + faults_.extra_delay + late;
  if (numbers_.burst_per_s > 0.0 && arrival >= held_until_ &&
      network_.uniform() < numbers_.burst_per_s / numbers_.rate_hz) {
    held_until_ = arrival + duration_of(numbers_.burst_s);
  }
  return std::max(arrival, held_until_);
}

/// Applies the faults that a test has set.
void PoseSource::spoil(PoseSample& sample) {
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
  if (faults_.fault) {
    faults_.fault(sample);
  }
  if (faults_.not_finite) {
    sample.position_w_m.x() = std::numeric_limits<double>::quiet_NaN();
  }
}

void PoseSource::capture(core::TimePoint at, const VehicleState& truth, double yaw_rad, core::TimePoint truth_at) {
  const double ahead_s = core::seconds<double>(at - truth_at);
  PoseSample sample{.sequence = static_cast<std::uint32_t>(captures_),
                    .captured = at,
                    .stamp = own_time(at),
                    .position_w_m = truth.position_w_m + ahead_s * truth.velocity_w_m_s,
                    .yaw_rad = yaw_rad + ahead_s * truth.rate_b_rad_s.z()};
  for (Eigen::Index i = 0; i < 3; ++i) {
    sample.position_w_m[i] += numbers_.noise_m * random_.normal();
  }
  sample.yaw_rad += numbers_.noise_rad * random_.normal();
  const bool drops = random_.uniform() < numbers_.dropout_per_s / numbers_.rate_hz;
  const double jitter = random_.uniform();
  if (drops && at >= back_) {  // a dropout does not extend a running one
    back_ = at + duration_of(numbers_.dropout_s);
  }
  if (numbers_.reported_age == ReportedAge::kConstant) {
    sample.stamp = own_time(at + duration_of(numbers_.latency_s - numbers_.reported_age_s));
  }
  spoil(sample);
  if (numbers_.quantum_m > 0.0) {
    for (Eigen::Index i = 0; i < 3; ++i) {
      sample.position_w_m[i] = numbers_.quantum_m * std::round(sample.position_w_m[i] / numbers_.quantum_m);
    }
  }
  if (at < back_ || faults_.silent) {
    return;
  }
  const core::TimePoint arrival = arrival_of(at, jitter);
  const auto behind = std::upper_bound(air_.begin(), air_.end(), arrival,
                                       [](core::TimePoint when, const Travelling& one) { return when < one.arrival; });
  air_.insert(behind, {arrival, sample});
}

std::optional<PoseSample> PoseSource::step(core::TimePoint now, const VehicleState& truth, double yaw_rad,
                                           core::TimePoint truth_at) {
  for (; next_ <= now; next_ = capture_time(captures_)) {
    ++captures_;
    if (now - next_ < kAsleep) {
      capture(next_, truth, yaw_rad, truth_at);
    }
  }
  if (air_.empty() || air_.front().arrival > now) {
    return std::nullopt;
  }
  const PoseSample arrived = air_.front().sample;
  air_.pop_front();
  return arrived;
}

}  // namespace m100::sim
