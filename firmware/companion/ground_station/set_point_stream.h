// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>

#include "firmware/companion/ground_station/goal_planner.h"
#include "protocol/mavlink/frame.h"

namespace m100::companion {

/// What a stream of set points may demand. The acceleration bounds the tilt, too: asin(acceleration / gravity).
struct StreamLimits {
  double speed_m_s = 1.5;
  double acceleration_m_s2 = 2.0;
  double climb_m_s = 1.0;
  double yaw_rate_rad_s = 0.8;
};

/// Flies set points that come 5 to 100 times a second: position, velocity or both, acceleration, yaw and yaw rate, as
/// their mask names them. One set point alone is a goal. The second within kPause begins a stream, unless it repeats
/// the place of a goal. kPause after the last one the reference brakes and holds.
///
/// The stream is flown kPause late, so that the law sees what comes. Each set point replaces the trajectory from the
/// present tick: a polynomial leads each axis from the present motion to that of the set point, when it is due, or
/// later if only a longer time keeps speed, acceleration and fence. What follows is predicted: constant velocity, into
/// which the acceleration fades in kFade. A set point is as old as its time stamp says, against the smallest delay
/// seen, so the jitter of its way here has no effect; without a rising stamp it is as old as its arrival. A position
/// that cannot be reached within kLongestJoin is flown to as to a goal. Velocity is cut where it exceeds its limit or
/// what can be stopped before the fence.
///
/// Cost of a set point: at most kMaxAttempts * kSamples evaluations of four polynomials, or those of a goal. No heap.
template <typename T>
class SetPointStream {
 public:
  static constexpr core::Duration kPause = std::chrono::milliseconds(300);

  SetPointStream(ref::Trajectory<T>& trajectory, const core::Fence& fence, const StreamLimits& limits)
      : trajectory_(trajectory), fence_(fence), limits_(limits) {}

  /// Call it in every tick, before take(). @returns kStreamEnded in the tick in which a stream ends.
  std::optional<GoalResult> update(core::TimePoint now, bool flies, GoalPlanner<T>& goals);
  /// Takes a set point, which may be a goal. @param flies control is ours, and the failsafe passes commands of the law.
  GoalResult take(const mavlink::SetPositionTargetLocalNed& set_point, mavlink::Address from, core::TimePoint now,
                  bool flies, const app::SourceFrame<T>& source, GoalPlanner<T>& goals);
  /// An order to hold has stopped the reference: the present stream has no effect any more.
  void hold() { phase_ = phase_ == Phase::kStream ? Phase::kHeld : phase_; }
  /// The speed, acceleration or distance that was cut to its limit, or that is to be flown first; by the last answer.
  double exceeding() const { return exceeding_; }

 private:
  using Axis = ref::AxisReference<double>;
  /// x, y, z, yaw.
  using PolynomialPath = std::array<ref::Polynomial<double>, ref::kDimensions>;
  enum class Phase : std::uint8_t { kNone, kFirst, kStream, kHeld };

  /// The motion that a set point demands, in the flight's world.
  struct Target {
    std::array<Axis, ref::kDimensions> axis{};
    std::array<bool, ref::kDimensions> has_position{};
    bool has_velocity = false;
    core::TimePoint at{};  ///< when it is valid, by our clock
  };

  GoalResult begin(const mavlink::SetPositionTargetLocalNed& set_point, core::TimePoint now, bool flies,
                   const app::SourceFrame<T>& source, GoalPlanner<T>& goals);
  void remember(const mavlink::SetPositionTargetLocalNed& set_point, mavlink::Address from, core::TimePoint now);
  /// When the set point was valid, by its stamp. Call it before remember().
  core::TimePoint time_of(std::uint32_t stamp_ms, core::TimePoint now);
  static Target target_of(const mavlink::SetPositionTargetLocalNed& set_point, core::TimePoint at,
                          const app::SourceFrame<T>& source);
  /// The velocity of positions that come without one: the difference of the last two.
  void derive_velocity(Target& target);
  /// Keeps the target inside fence and limits. @returns what was cut.
  GoalResult cut(Target& target);
  GoalResult join(const Target& target, core::TimePoint now, GoalPlanner<T>& goals);
  bool join_in(const Target& target, const std::array<Axis, ref::kDimensions>& from, double time_s,
               core::TimePoint now);
  bool within_limits(const PolynomialPath& way, double time_s) const;

  ref::Trajectory<T>& trajectory_;
  core::Fence fence_;
  StreamLimits limits_;
  Phase phase_ = Phase::kNone;
  mavlink::SetPositionTargetLocalNed last_;
  mavlink::Address from_;
  core::TimePoint last_at_{};
  std::int64_t min_delay_us_ = 0;  ///< arrival by our clock minus stamp
  std::optional<Target> before_;   ///< the target before this one, for derive_velocity()
  double exceeding_ = 0.0;
};

extern template class SetPointStream<float>;
extern template class SetPointStream<double>;

}  // namespace m100::companion
