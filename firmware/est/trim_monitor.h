// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/maths.h"
#include "firmware/est/estimate.h"
#include "firmware/model/vehicle.h"

namespace m100::est {

/// Counts on the two tilt sticks.
template <typename T>
struct TrimCounts {
  T roll{0};
  T pitch{0};
};

/// Deviation of the sticks' trims from the vehicle file's, in counts (paper, III-A: trims 1080 and 998, neutral 1024).
template <typename T>
struct TrimReport {
  T roll_counts{0};
  T pitch_counts{0};
  bool converged = false;  ///< enough hover was observed
  bool drifted = false;    ///< converged, and at least one trim deviates by more than kLimit_counts
};

/// Averages the trim in hover: what learned() has, and the observer's input offset. Motion is left out, because the
/// offset then includes errors of the command gain. The sticks' neutrals follow learned(), because the law's own
/// compensation of the offset leaves the dead zone beside the true neutral. Nothing acts on the report.
///
/// Memory: ten numbers. Cost: some ten products.
template <typename T>
class TrimMonitor {
 public:
  static constexpr T kTimeConstant_s = T(5);
  static constexpr T kConverged_s = T(10);  ///< of hover, in total
  static constexpr T kLimit_counts = T(15);
  static constexpr T kStill_m_s = T(0.2);
  static constexpr T kLearned_s = T(2);     ///< time constant of learned()
  static constexpr T kMax_counts = T(300);  ///< of learned()

  explicit TrimMonitor(const model::Vehicle& vehicle)
      : roll_counts_per_rad_(static_cast<T>(1.0 / vehicle.roll.scale_per_count)),
        pitch_counts_per_rad_(static_cast<T>(1.0 / vehicle.pitch.scale_per_count)) {}

  /// Once per tick.
  /// @param holds the sticks are ours, and FlightController::holds()
  void update(const Estimate<T>& estimate, bool holds, T step_s) {
    const TrimCounts<T> left = counts(estimate, estimate.x.input_offset_rad, estimate.y.input_offset_rad);
    now_ = {.roll = learned_.roll + left.roll, .pitch = learned_.pitch + left.pitch};
    learned_share_ = T(0);
    if (!holds || !estimate.healthy || !still(estimate.x.velocity_m_s) || !still(estimate.y.velocity_m_s)) {
      return;
    }
    learn(left, step_s < kLearned_s ? step_s / kLearned_s : T(1));
    // A plain mean until the time constant has passed, then a first-order low-pass.
    hover_s_ = hover_s_ < kConverged_s ? hover_s_ + step_s : hover_s_;
    const T share = step_s / (hover_s_ < kTimeConstant_s ? hover_s_ : kTimeConstant_s);
    report_.roll_counts += share * (now_.roll - report_.roll_counts);
    report_.pitch_counts += share * (now_.pitch - report_.pitch_counts);
    report_.converged = hover_s_ >= kConverged_s;
    report_.drifted = report_.converged && (beyond(report_.roll_counts) || beyond(report_.pitch_counts));
  }

  const TrimReport<T>& report() const { return report_; }
  /// Stick deflections that hold the position, in counts from the learned trims. They cancel the input offset
  /// and tilt the aircraft against the disturbance. The dead zone is not compensated.
  TrimCounts<T> holding(const Estimate<T>& estimate) const {
    constexpr T kPerGravity = static_cast<T>(1.0 / model::kGravity_m_s2);
    return counts(estimate, estimate.x.input_offset_rad + kPerGravity * estimate.x.disturbance_m_s2,
                  estimate.y.input_offset_rad - kPerGravity * estimate.y.disturbance_m_s2);
  }
  /// The trims that the sticks' neutrals take over from the observer's input offset in hover, in counts from the
  /// vehicle file's; and the share of the offset that they took in this tick.
  const TrimCounts<T>& learned() const { return learned_; }
  T learned_share() const { return learned_share_; }
  /// Stick deflections that cancel the input offset of this tick, in counts from the vehicle file's trims.
  const TrimCounts<T>& now() const { return now_; }

 private:
  /// If a trim would leave the file's by more than kMax_counts, the range of a trim in a vehicle file, none is learned.
  void learn(const TrimCounts<T>& left, T share) {
    const TrimCounts<T> next{.roll = learned_.roll + share * left.roll, .pitch = learned_.pitch + share * left.pitch};
    const auto fits = [](T counts) { return counts * counts <= kMax_counts * kMax_counts; };
    if (fits(next.roll) && fits(next.pitch)) {
      learned_ = next;
      learned_share_ = share;
    }
  }
  // The counts that cancel tilts x and y of the yaw-free frame (a = g (x, -y)), turned into the body frame.
  TrimCounts<T> counts(const Estimate<T>& estimate, T x_rad, T y_rad) const {
    const core::SinCos<T>& yaw = estimate.heading();
    const T pitch_rad = yaw.cosine * x_rad - yaw.sine * y_rad;
    const T roll_rad = yaw.sine * x_rad + yaw.cosine * y_rad;
    return {.roll = -roll_rad * roll_counts_per_rad_, .pitch = -pitch_rad * pitch_counts_per_rad_};
  }
  static bool still(T speed_m_s) { return speed_m_s > -kStill_m_s && speed_m_s < kStill_m_s; }
  static bool beyond(T counts) { return counts > kLimit_counts || counts < -kLimit_counts; }

  T roll_counts_per_rad_;
  T pitch_counts_per_rad_;
  T hover_s_{0};
  T learned_share_{0};
  TrimCounts<T> learned_;
  TrimCounts<T> now_;
  TrimReport<T> report_;
};

}  // namespace m100::est
