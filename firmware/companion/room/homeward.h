// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/room/goals.h"

namespace m100::companion {

/// What a flight does on a low battery.
struct HomeSettings {
  double low_percent = 0.0;  ///< threshold of the charge; 0: the battery is ignored
  ref::SpeedLimits limits;   ///< of the way
};

/// The settings as a note in the log: "low_percent speed acceleration yaw_rate".
std::string home_note(const HomeSettings& settings);
/// @returns nothing: the note is of another version.
std::optional<HomeSettings> home_of_note(const std::string& note);

/// Brings an aircraft with a low battery to where its flight began: by a goal, with the limits of goals, inside the
/// fence. From then on nothing else changes the course. Landing or giving control back there is left to the caller.
///
/// A low charge counts after it has been reported for three seconds; the report comes once a second. A charge of zero
/// before any other value means that the charge is unknown. An excitation in motion is flown to its end first. The
/// class uses only data that are in the log, so that a replay does the same. No heap. T is float or double.
template <typename T>
class Homeward {
 public:
  enum class State : std::uint8_t { kNotYet, kFlies, kThere };

  Homeward(ref::Trajectory<T>& trajectory, const core::Fence& fence, const ref::Waypoint<T>& home,
           const HomeSettings& settings)
      : goals_(trajectory, fence, settings.limits), home_(home), low_percent_(settings.low_percent) {}

  /// Call it after each tick: changes the trajectory from the next tick.
  template <typename S>
  State watch(const app::FlightController<T, S>& controller, core::TimePoint now);
  State state() const { return state_; }
  double low_percent() const { return low_percent_; }

 private:
  static constexpr core::Duration kSure = std::chrono::seconds(3);
  static constexpr core::Duration kArrives = std::chrono::seconds(5);  ///< longest wait after the end of the way
  static constexpr double kNear_m = 0.3;

  bool is_near(const est::Estimate<T>& at) const {
    const core::Vector<T, 3> away =
        goals_.inside(home_).position_w_m - core::Vector<T, 3>(at.x.position_m, at.y.position_m, at.height_m);
    return away.squaredNorm() < static_cast<T>(kNear_m * kNear_m);
  }

  Goals<T> goals_;
  ref::Waypoint<T> home_;
  double low_percent_;
  bool charge_is_told_ = false;
  State state_ = State::kNotYet;
  std::optional<core::TimePoint> low_since_;
  std::optional<core::TimePoint> rests_since_;
};

template <typename T>
template <typename S>
typename Homeward<T>::State Homeward<T>::watch(const app::FlightController<T, S>& controller, core::TimePoint now) {
  const bool by_law = safety::passes_law(controller.supervisor().rung());
  goals_.watch(now, by_law, controller.started(), controller.estimate());
  const std::uint8_t percent = controller.link().telemetry().battery_percent;
  charge_is_told_ = charge_is_told_ || percent > 0;
  const bool is_low = charge_is_told_ && low_percent_ > 0.0 && percent <= low_percent_;
  low_since_ = is_low ? low_since_.value_or(now) : std::optional<core::TimePoint>();
  if (!by_law || !controller.link().authority().in_control) {
    state_ = State::kNotYet;
    return state_;
  }
  if (state_ == State::kNotYet && is_low && now - *low_since_ >= kSure && !controller.excitation().moves()) {
    state_ = goals_.fly_to(home_, now) ? State::kFlies : State::kThere;
    rests_since_.reset();
  } else if (state_ == State::kFlies && goals_.rests(now)) {
    rests_since_ = rests_since_.value_or(now);
    const bool arrived = is_near(controller.estimate()) || now - *rests_since_ >= kArrives;
    state_ = arrived ? State::kThere : State::kFlies;
  }
  return state_;
}

}  // namespace m100::companion
