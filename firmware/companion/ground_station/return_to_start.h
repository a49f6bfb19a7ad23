// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/ground_station/goal_planner.h"

namespace m100::companion {

/// What a flight does on a low battery.
struct ReturnSettings {
  double low_percent = 0.0;  ///< threshold of the charge; 0: the battery is ignored
  ref::SpeedLimits limits;   ///< of the way
};

/// The settings as a note in the log: "low_percent speed acceleration yaw_rate".
std::string home_note(const ReturnSettings& settings);
/// @returns nullopt: the note is of another version.
std::optional<ReturnSettings> home_of_note(const std::string& note);

/// Brings an aircraft with a low battery to `home`, where its course begins, as to a goal. The caller must not let
/// anything else change the course then, and lands or gives control back.
///
/// The battery is low if the charge has been at or below its threshold for three seconds. A charge of zero before any
/// other value means that the charge is unknown. A piece of an excitation that has begun is flown to its end first. The
/// return does not end the excitation: a piece may still begin if the aircraft rests kNear_m or more from home but
/// within the excitation's tolerance on each axis. Then it flies until kArrived, at most kArrivalTimeout later, when
/// the caller ends it with the flight by the law. The law hovers where the aircraft is after a landing that was ordered
/// and is not flown. No heap. T is float or double.
template <typename T>
class ReturnToStart {
 public:
  enum class State : std::uint8_t { kInactive, kReturning, kArrived };

  ReturnToStart(ref::Trajectory<T>& trajectory, const core::Fence& fence, const ref::Waypoint<T>& home,
                const ReturnSettings& settings)
      : goals_(trajectory, fence, settings.limits), home_(home), low_percent_(settings.low_percent) {}

  /// Call it after each tick: changes the trajectory from the next tick.
  template <typename S>
  State update(const app::FlightController<T, S>& controller, core::TimePoint now);
  State state() const { return state_; }
  double low_percent() const { return low_percent_; }

 private:
  static constexpr core::Duration kLowConfirmTime = std::chrono::seconds(3);
  static constexpr core::Duration kArrivalTimeout = std::chrono::seconds(5);  ///< longest wait after the end of the way
  static constexpr double kNear_m = 0.3;

  bool is_near(const est::Estimate<T>& at) const {
    const core::Vector<T, 3> away =
        goals_.clamp_to_fence(home_).position_w_m - core::Vector<T, 3>(at.x.position_m, at.y.position_m, at.height_m);
    return away.squaredNorm() < static_cast<T>(kNear_m * kNear_m);
  }

  /// The charge has been low for kLowConfirmTime. A charge of zero before any other is none that was reported.
  bool stays_low(std::uint8_t percent, core::TimePoint now) {
    charge_reported_ = charge_reported_ || percent > 0;
    const bool is_low = charge_reported_ && low_percent_ > 0.0 && percent <= low_percent_;
    low_since_ = is_low ? low_since_.value_or(now) : std::optional<core::TimePoint>();
    return is_low && now - *low_since_ >= kLowConfirmTime;
  }

  GoalPlanner<T> goals_;
  ref::Waypoint<T> home_;
  double low_percent_;
  bool charge_reported_ = false;
  bool hovers_ = false;  ///< in place of a landing, until control goes back
  State state_ = State::kInactive;
  std::optional<core::TimePoint> low_since_;
  std::optional<core::TimePoint> rests_since_;
};

template <typename T>
template <typename S>
typename ReturnToStart<T>::State ReturnToStart<T>::update(const app::FlightController<T, S>& controller,
                                                          core::TimePoint now) {
  const bool by_law = safety::passes_law(controller.supervisor().failsafe_state());
  const bool is_ours = controller.link().authority().in_control;
  if (controller.hovers_here()) {
    goals_.stay();
  }
  hovers_ = controller.hovers_here() || (hovers_ && is_ours);
  goals_.update(now, by_law, controller.started(), controller.estimate());
  const bool is_low = stays_low(controller.link().telemetry().battery_percent, now);
  if (!by_law || !is_ours || hovers_) {
    state_ = State::kInactive;
    return state_;
  }
  if (state_ == State::kInactive && is_low && !controller.excitation().moves()) {
    state_ = goals_.fly_to(home_, now) ? State::kReturning : State::kArrived;
    rests_since_.reset();
  } else if (state_ == State::kReturning && goals_.at_rest(now)) {
    rests_since_ = rests_since_.value_or(now);
    const bool arrived = is_near(controller.estimate()) || now - *rests_since_ >= kArrivalTimeout;
    state_ = arrived ? State::kArrived : State::kReturning;
  }
  return state_;
}

}  // namespace m100::companion
