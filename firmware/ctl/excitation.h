// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/core/time.h"
#include "firmware/est/estimate.h"
#include "firmware/ref/window.h"

namespace m100::ctl {

enum class ExcitedStick : std::uint8_t { kRoll, kPitch, kThrottle, kYaw };
inline constexpr std::size_t kStickAxes = 4;

/// One number of a command, in the order of ExcitedStick: roll, pitch, climb, yaw rate.
template <typename C>
constexpr auto& value_of(C& command, std::size_t axis) {
  return axis == 0   ? command.roll_rad
         : axis == 1 ? command.pitch_rad
         : axis == 2 ? command.climb_m_s
                     : command.yaw_rate_rad_s;
}

/// Limits beyond which an excitation is aborted. Distance, braking and speed are along the moved axis, in m, m/s^2 and
/// m/s; for yaw in rad, rad/s^2 and rad/s.
struct ExcitationLimits {
  double distance = 0.0;  ///< from the reference, braking distance included: |s| + v^2 / (2 a), v outwards
  double braking = 1.0;   ///< a, the assumed deceleration
  double speed = 0.0;
  double tilt_rad = 0.0;  ///< of both axes together
};

/// Consecutive samples on one stick. Between two pieces the law flies back to the reference.
struct ExcitationPiece {
  ExcitedStick axis = ExcitedStick::kRoll;
  std::size_t begin = 0;  ///< in ExcitationPlan::counts
  std::size_t count = 0;
};

/// Stick movements for identification, computed before the flight. The caller owns the viewed data. Without pieces
/// there is no excitation.
struct ExcitationPlan {
  core::Duration period = std::chrono::milliseconds(20);
  std::span<const std::int16_t> counts{};  ///< from the trim; positive: roll right, pitch forward, climb, yaw right
  std::span<const ExcitationPiece> pieces{};
  std::array<ExcitationLimits, kStickAxes> limits{};
};

/// The tilt sticks that hold the position now, in counts from their trims.
template <typename T>
struct HoldingSticks {
  T roll_counts{0};
  T pitch_counts{0};
};

/// Flies a plan piece by piece: the plan moves one stick, the law the others. Before each piece the law has to bring
/// the aircraft to rest at its place; after the last one, and after an abort, the law has all sticks again.
///
/// Cost: O(1) per tick, some ten comparisons. No heap. T is float or double.
template <typename T>
class Excitation {
 public:
  enum class State : std::uint8_t { kIdle, kReturning, kMoving, kOver, kAborted };
  enum class Abort : std::uint8_t {
    kNone,
    kFailsafe,  ///< the failsafe left kNominal or control was lost, for example because the pilot took it
    kFence,     ///< the geofence limiter brakes: the aircraft might not stop before a side of the fence
    kDistance,  ///< distance and braking distance exceed ExcitationLimits::distance
    kTilt,
    kSpeed,
    kNotAtRest,  ///< the law did not bring the aircraft to rest at the place within kPatience
  };
  static constexpr core::Duration kPatience = std::chrono::seconds(30);
  static constexpr core::Duration kRest = std::chrono::milliseconds(800);

  explicit Excitation(const ExcitationPlan& plan) : plan_(plan) {}

  /// Begins the return before the first piece; does nothing if the plan has no pieces. Call it when the failsafe has
  /// reached kNominal.
  void start(core::TimePoint now);

  /// Call it before update() in every tick with returns().
  /// @param holding roll and pitch sticks, in counts from their trims, that would hold the position now. Their mean
  ///   over the time at rest becomes holding_counts().
  void rest_at(const HoldingSticks<T>& holding);
  /// Once per tick, before a command is chosen.
  /// @param may the failsafe is in kNominal, control is ours. @param brakes the geofence limiter brakes.
  void update(const est::Estimate<T>& estimate, const ref::Window<T>& reference, bool may, bool brakes,
              core::TimePoint now);

  State state() const { return state_; }
  Abort abort() const { return abort_; }
  bool moves() const { return state_ == State::kMoving; }
  ExcitedStick axis() const { return moves_piece() ? plan_.pieces[piece_].axis : ExcitedStick::kRoll; }
  /// Whether the law brings the aircraft to rest before a piece.
  bool returns() const { return state_ == State::kReturning; }
  /// Counts that the caller adds to counts() to hold against wind and trim: the mean of rest_at(), at most 200 in size.
  /// 0 for throttle and yaw, and while the plan moves no stick.
  int holding_counts() const;
  /// The plan's counts for the stick of axis(), from its trim; 0 while the plan moves no stick.
  int counts() const { return moves() ? plan_.counts[plan_.pieces[piece_].begin + sample_] : 0; }
  std::size_t piece() const { return piece_; }
  std::size_t sample() const { return sample_; }
  /// Distance from the reference, and speed, along axis(), positive where a positive stick moves the aircraft.
  T distance() const { return distance_; }
  T speed() const { return speed_; }
  /// The excitation lasts from start() to its end or abort; until then ended() is the time of the last update().
  core::TimePoint began() const { return began_; }
  core::TimePoint ended() const { return ended_; }
  static std::string_view name(Abort abort);

 private:
  bool moves_piece() const { return piece_ < plan_.pieces.size(); }
  void update_distance(const est::Estimate<T>& estimate, const ref::Window<T>& reference);
  Abort limit_reached(const est::Estimate<T>& estimate, bool brakes) const;
  bool at_rest(const est::Estimate<T>& estimate, const ref::Window<T>& reference) const;
  void end(Abort why);

  ExcitationPlan plan_;
  State state_ = State::kIdle;
  Abort abort_ = Abort::kNone;
  std::size_t piece_ = 0;
  std::size_t sample_ = 0;
  core::TimePoint began_{};
  core::TimePoint ended_{};
  core::TimePoint since_{};     ///< of the state
  core::TimePoint restless_{};  ///< when the aircraft was last not at rest
  HoldingSticks<T> holding_;
  T rested_{0};  ///< ticks in the mean of holding_
  T distance_{0};
  T speed_{0};
};

extern template class Excitation<float>;
extern template class Excitation<double>;

}  // namespace m100::ctl
