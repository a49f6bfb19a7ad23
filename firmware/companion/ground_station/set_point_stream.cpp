// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/ground_station/set_point_stream.h"

#include <algorithm>
#include <cmath>

#include "firmware/companion/ground_station/set_point_mask.h"
#include "firmware/core/frames.h"
#include "firmware/core/maths.h"

namespace m100::companion {
namespace {

constexpr double kDelay_s =
    core::seconds<double>(SetPointStream<double>::kPause);  ///< the last set point is reached as the end shows
constexpr double kShortestJoin_s = 0.1;
constexpr double kLongestJoin_s = 1.0;
constexpr double kLongestTurn_s = 4.0;  ///< of a velocity
constexpr double kTimeRatio = 1.25;     ///< ratio of successive times that are tried
constexpr int kMaxAttempts = 17;        ///< from kShortestJoin_s to kLongestTurn_s
constexpr int kSamples = 20;
constexpr double kFade_s = 0.5;
constexpr double kPreview_s = 3.0;  ///< longer than horizon, transport delay and kPause
/// A reference that has fallen behind may be faster by this factor until it has caught up.
constexpr double kCatchUp = 1.1;
constexpr std::size_t kYawAxis = 3;
constexpr core::Duration kMinInterval = std::chrono::milliseconds(5);

using SetPoint = mavlink::SetPositionTargetLocalNed;
using Vector = core::Vector<double, 3>;
using Axis = ref::AxisReference<double>;

/// kAccepted, or why the set point can be flown neither as a goal nor in a stream.
GoalResult fault_of(const SetPoint& set_point) {
  if (set_point.coordinate_frame != kLocalNed) {
    return GoalResult::kFrame;
  }
  if (!is_whole(set_point)) {
    return GoalResult::kPartialMask;
  }
  if (!is_finite(set_point)) {
    return GoalResult::kNotFinite;
  }
  return names(set_point, kIgnoreYaw) && !core::is_within_turn(set_point.yaw) ? GoalResult::kDegrees
                                                                              : GoalResult::kAccepted;
}

/// The same set point with its place alone.
SetPoint place_of(SetPoint set_point) {
  set_point.type_mask =
      static_cast<std::uint16_t>(set_point.type_mask | kIgnoreVelocity | kIgnoreAcceleration | kIgnoreYawRate);
  return set_point;
}

bool is_same_place(const SetPoint& a, const SetPoint& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z && a.yaw == b.yaw;
}

Vector world(float north, float east, float down) {
  return {static_cast<double>(north), -static_cast<double>(east), -static_cast<double>(down)};
}

/// The motion a time later: the acceleration fades to zero within `fade_s`.
Axis ahead(const Axis& from, double time_s, double fade_s) {
  const double fading_s = std::min(time_s, fade_s);
  Axis then = ref::after(from, fading_s, -from.acceleration_m_s2 / fade_s);
  if (time_s > fade_s) {
    then.acceleration_m_s2 = 0.0;
    then.position_m += then.velocity_m_s * (time_s - fade_s);
  }
  return then;
}

/// Shortens the x, y and z parts of a member to a length. @returns the length before.
double shorten(std::array<Axis, ref::kDimensions>& axes, double Axis::*member, double largest) {
  const double length = Vector(axes[0].*member, axes[1].*member, axes[2].*member).norm();
  for (std::size_t axis = 0; length > largest && axis < kYawAxis; ++axis) {
    axes[axis].*member *= largest / length;
  }
  return length;
}

core::Duration duration_of(double time_s) { return core::Duration(std::llround(time_s * 1e6)); }

}  // namespace

template <typename T>
std::optional<GoalResult> SetPointStream<T>::update(core::TimePoint now, bool flies, GoalPlanner<T>& goals) {
  if (flies && (phase_ == Phase::kNone || now - last_at_ <= kPause)) {
    return {};
  }
  const bool ends = phase_ == Phase::kStream && goals.hold(now, flies);
  phase_ = Phase::kNone;
  before_.reset();
  return ends ? std::optional(GoalResult::kStreamEnded) : std::nullopt;
}

template <typename T>
GoalResult SetPointStream<T>::take(const SetPoint& set_point, mavlink::Address from, core::TimePoint now, bool flies,
                                   const app::SourceFrame<T>& source, GoalPlanner<T>& goals) {
  exceeding_ = 0.0;
  if (phase_ == Phase::kNone) {
    const GoalResult begun = begin(set_point, now, flies, source, goals);
    if (begun == GoalResult::kAccepted || begun == GoalResult::kUnchanged || begun == GoalResult::kFirst) {
      phase_ = Phase::kFirst;
      min_delay_us_ = now.time_since_epoch().count() - std::int64_t{set_point.time_boot_ms} * 1000;
      remember(set_point, from, now);
    }
    return begun;
  }
  if (from != from_) {
    return GoalResult::kSecondSender;
  }
  if (set_point.type_mask != last_.type_mask) {
    return GoalResult::kMixedMasks;
  }
  if (phase_ == Phase::kHeld) {
    last_at_ = now;
    return GoalResult::kHeld;
  }
  const bool repeats = names_only_a_place(set_point) && is_same_place(set_point, last_);
  if (phase_ == Phase::kFirst && (repeats || !is_whole(set_point))) {
    const GoalResult goal = goals.take(set_point, now, flies, source);
    remember(set_point, from, now);
    return goal;
  }
  if (const GoalResult fault = fault_of(set_point); fault != GoalResult::kAccepted) {
    return fault;
  }
  Target target = target_of(set_point, time_of(set_point.time_boot_ms, now), source);
  phase_ = Phase::kStream;
  remember(set_point, from, now);
  derive_velocity(target);
  before_ = target;
  const GoalResult limited = cut(target);
  const GoalResult joined = join(target, now, goals);
  return joined == GoalResult::kStream ? limited : joined;
}

/// What comes alone is a goal: its place counts, and a motion without a place waits for the next set point.
template <typename T>
GoalResult SetPointStream<T>::begin(const SetPoint& set_point, core::TimePoint now, bool flies,
                                    const app::SourceFrame<T>& source, GoalPlanner<T>& goals) {
  if (names_only_a_place(set_point)) {
    return goals.take(set_point, now, flies, source);
  }
  if (const GoalResult fault = fault_of(set_point); fault != GoalResult::kAccepted) {
    return fault;
  }
  if (names(set_point, kIgnorePosition)) {
    return goals.take(place_of(set_point), now, flies, source);
  }
  return flies ? GoalResult::kFirst : GoalResult::kNotFlying;
}

template <typename T>
void SetPointStream<T>::remember(const SetPoint& set_point, mavlink::Address from, core::TimePoint now) {
  last_ = set_point;
  from_ = from;
  last_at_ = now;
}

template <typename T>
core::TimePoint SetPointStream<T>::time_of(std::uint32_t stamp_ms, core::TimePoint now) {
  // Modulo 2^32, so the stamps may wrap.
  const core::Duration step = std::chrono::milliseconds(static_cast<std::int32_t>(stamp_ms - last_.time_boot_ms));
  const std::int64_t delay_us = now.time_since_epoch().count() - std::int64_t{stamp_ms} * 1000;
  const core::Duration elapsed = now - last_at_;
  const bool is_stamped = step > core::Duration{0} && step - elapsed <= kPause && elapsed - step <= kPause;
  // A slow drift of the two clocks, up to a thousandth, is followed.
  const std::int64_t drifted_us = min_delay_us_ + elapsed.count() / 1000;
  min_delay_us_ = is_stamped ? std::min(delay_us, drifted_us) : delay_us;
  return now - core::Duration(delay_us - min_delay_us_);
}

template <typename T>
typename SetPointStream<T>::Target SetPointStream<T>::target_of(const SetPoint& set_point, core::TimePoint at,
                                                                const app::SourceFrame<T>& source) {
  const auto turned = [&](const Vector& v) -> Vector {
    const core::Vector<T, 3> origin = core::Vector<T, 3>::Zero();
    return (source.to_flight(v.template cast<T>()) - source.to_flight(origin)).template cast<double>();
  };
  Target target;
  target.at = at;
  target.has_velocity = names(set_point, kIgnoreVelocity);
  const core::Vector<T, 3> named = world(set_point.x, set_point.y, set_point.z).template cast<T>();
  const Vector position = source.to_flight(named).template cast<double>();
  const Vector velocity = turned(world(set_point.vx, set_point.vy, set_point.vz));
  const Vector acceleration = turned(world(set_point.afx, set_point.afy, set_point.afz));
  for (std::size_t axis = 0; axis < kYawAxis; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    target.has_position[axis] = names(set_point, kIgnorePosition);
    target.axis[axis] = {.position_m = target.has_position[axis] ? position[i] : 0.0,
                         .velocity_m_s = target.has_velocity ? velocity[i] : 0.0,
                         .acceleration_m_s2 = names(set_point, kIgnoreAcceleration) ? acceleration[i] : 0.0};
  }
  target.has_position[kYawAxis] = names(set_point, kIgnoreYaw);
  target.axis[kYawAxis] = {
      .position_m = names(set_point, kIgnoreYaw)
                        ? static_cast<double>(source.turn_rad()) - static_cast<double>(set_point.yaw)
                        : 0.0,
      .velocity_m_s = names(set_point, kIgnoreYawRate) ? -static_cast<double>(set_point.yaw_rate) : 0.0};
  return target;
}

template <typename T>
void SetPointStream<T>::derive_velocity(Target& target) {
  if (target.has_velocity || !before_) {
    return;
  }
  const core::Duration interval = target.at - before_->at;
  for (std::size_t axis = 0; axis < kYawAxis; ++axis) {
    target.axis[axis].velocity_m_s =
        interval >= kMinInterval
            ? (target.axis[axis].position_m - before_->axis[axis].position_m) / core::seconds<double>(interval)
            : before_->axis[axis].velocity_m_s;
  }
}

template <typename T>
GoalResult SetPointStream<T>::cut(Target& target) {
  GoalResult result = GoalResult::kStream;
  const auto note = [&](double named, double largest, GoalResult what) {
    if (named > largest) {
      exceeding_ = named;
      result = what;
    }
  };
  note(shorten(target.axis, &Axis::acceleration_m_s2, limits_.acceleration_m_s2), limits_.acceleration_m_s2,
       GoalResult::kStreamAcceleration);
  note(shorten(target.axis, &Axis::velocity_m_s, limits_.speed_m_s), limits_.speed_m_s, GoalResult::kStreamSpeed);
  Axis& height = target.axis[2];
  note(std::abs(height.velocity_m_s), limits_.climb_m_s, GoalResult::kStreamSpeed);
  height.velocity_m_s = std::clamp(height.velocity_m_s, -limits_.climb_m_s, limits_.climb_m_s);
  Axis& yaw = target.axis[kYawAxis];
  note(std::abs(yaw.velocity_m_s), limits_.yaw_rate_rad_s, GoalResult::kStreamSpeed);
  yaw.velocity_m_s = std::clamp(yaw.velocity_m_s, -limits_.yaw_rate_rad_s, limits_.yaw_rate_rad_s);
  const ref::Window<T> window = trajectory_.window(last_at_, core::Duration{0});
  const std::array<double, 3> here{static_cast<double>(window.x[0].position_m),
                                   static_cast<double>(window.y[0].position_m),
                                   static_cast<double>(window.height.position_m)};
  for (std::size_t axis = 0; axis < fence_.side.size(); ++axis) {
    const core::Fence::Side& side = fence_.side[axis];
    Axis& wanted = target.axis[axis];
    if (target.has_position[axis]) {
      const double inside = std::clamp(wanted.position_m, side.low_m, side.high_m);
      note(std::abs(wanted.position_m - inside), 1e-3, GoalResult::kStreamFence);
      wanted.position_m = inside;
    }
    // From there it stops before the side: at the limit where the places brake by themselves, at half of it otherwise.
    const double at = target.has_position[axis] ? wanted.position_m : here[axis];
    const double brakes = limits_.acceleration_m_s2 * (target.has_position[axis] ? 2.0 : 1.0);
    const double high_m_s = std::sqrt(brakes * std::max(0.0, side.high_m - at));
    const double low_m_s = -std::sqrt(brakes * std::max(0.0, at - side.low_m));
    if (wanted.velocity_m_s > high_m_s || wanted.velocity_m_s < low_m_s) {
      note(std::abs(wanted.velocity_m_s), 0.0, GoalResult::kStreamFence);
      wanted.velocity_m_s = std::clamp(wanted.velocity_m_s, low_m_s, high_m_s);
      wanted.acceleration_m_s2 = wanted.velocity_m_s * wanted.acceleration_m_s2 > 0.0 ? 0.0 : wanted.acceleration_m_s2;
    }
  }
  return result;
}

template <typename T>
GoalResult SetPointStream<T>::join(const Target& target, core::TimePoint now, GoalPlanner<T>& goals) {
  const ref::Window<T> window = trajectory_.window(now, core::Duration{0});
  const std::array<Axis, ref::kDimensions> from = motion_of(window);
  const bool has_place = target.has_position[0];
  const double longest_s = has_place ? kLongestJoin_s : kLongestTurn_s;
  double time_s = std::max(kDelay_s - core::seconds<double>(now - target.at), kShortestJoin_s);
  for (int tries = 0; tries < kMaxAttempts && time_s <= longest_s; ++tries, time_s *= kTimeRatio) {
    if (join_in(target, from, time_s, now)) {
      goals.stay();
      return GoalResult::kStream;
    }
  }
  if (!has_place) {
    (void)goals.hold(now, true);
    return GoalResult::kStreamFence;
  }
  ref::Waypoint<T> place;
  for (std::size_t axis = 0; axis < kYawAxis; ++axis) {
    place.position_w_m[static_cast<Eigen::Index>(axis)] = static_cast<T>(target.axis[axis].position_m);
    exceeding_ = std::hypot(axis == 0 ? 0.0 : exceeding_, target.axis[axis].position_m - from[axis].position_m);
  }
  place.yaw_rad =
      target.has_position[kYawAxis] ? core::wrap_pi(static_cast<T>(target.axis[kYawAxis].position_m)) : window.yaw_rad;
  (void)goals.fly_to(place, now);
  return GoalResult::kStreamFar;
}

template <typename T>
bool SetPointStream<T>::join_in(const Target& target, const std::array<Axis, ref::kDimensions>& from, double time_s,
                                core::TimePoint now) {
  const double ahead_s = std::max(core::seconds<double>(now - target.at) + time_s - kDelay_s, 0.0);
  PolynomialPath way, fades, coasts;
  const double fading_s = std::max(kFade_s - ahead_s, 0.0);
  for (std::size_t axis = 0; axis < way.size(); ++axis) {
    Axis wanted = target.axis[axis];
    bool has_position = target.has_position[axis];
    if (axis == kYawAxis && has_position) {
      const double turn = core::wrap_pi(wanted.position_m - from[axis].position_m);
      // A yaw that is far away is turned to at the limit, while the place is kept.
      has_position = std::abs(turn) <= limits_.yaw_rate_rad_s * time_s / 2.0;
      wanted.position_m = from[axis].position_m + turn;
      wanted.velocity_m_s = has_position ? wanted.velocity_m_s : std::copysign(limits_.yaw_rate_rad_s, turn);
    }
    way[axis] = polynomial_between(from[axis], ahead(wanted, ahead_s, kFade_s), has_position, time_s);
    const Axis end = way[axis].at(1.0, time_s);
    fades[axis].c = {end.position_m, end.velocity_m_s * fading_s, end.acceleration_m_s2 * fading_s * fading_s / 2.0,
                     -end.acceleration_m_s2 * fading_s * fading_s / 6.0};
    const Axis then = fading_s > 0.0 ? fades[axis].at(1.0, fading_s) : end;
    coasts[axis].c = {then.position_m, then.velocity_m_s * kPreview_s};
  }
  if (!within_limits(way, time_s)) {
    return false;
  }
  ref::Waypoint<T> here;
  here.position_w_m = Vector(from[0].position_m, from[1].position_m, from[2].position_m).template cast<T>();
  here.yaw_rad = static_cast<T>(from[kYawAxis].position_m);
  trajectory_.hold(here);
  trajectory_.start(now);
  (void)trajectory_.append_polynomial(way, duration_of(time_s));
  if (duration_of(fading_s) > core::Duration{0}) {
    (void)trajectory_.append_polynomial(fades, duration_of(fading_s));
  }
  (void)trajectory_.append_polynomial(coasts, duration_of(kPreview_s));
  return true;
}

template <typename T>
bool SetPointStream<T>::within_limits(const PolynomialPath& way, double time_s) const {
  const auto motion_at = [&](double s) {
    std::array<Axis, ref::kDimensions> motion;
    std::transform(way.begin(), way.end(), motion.begin(), [&](const auto& axis) { return axis.at(s, time_s); });
    return motion;
  };
  const auto length_of = [](const std::array<Axis, ref::kDimensions>& motion, double Axis::*member) {
    return Vector(motion[0].*member, motion[1].*member, motion[2].*member).norm();
  };
  // The present motion may exceed the limits, where a course or another stream led.
  const std::array<Axis, ref::kDimensions> from = motion_at(0.0);
  const double fastest = std::max(length_of(from, &Axis::velocity_m_s), kCatchUp * limits_.speed_m_s);
  const double strongest = std::max(length_of(from, &Axis::acceleration_m_s2), limits_.acceleration_m_s2);
  const double climbs = std::max(std::abs(from[2].velocity_m_s), kCatchUp * limits_.climb_m_s);
  const double turns = std::max(std::abs(from[kYawAxis].velocity_m_s), kCatchUp * limits_.yaw_rate_rad_s);
  for (int sample = 1; sample <= kSamples; ++sample) {
    const std::array<Axis, ref::kDimensions> motion = motion_at(static_cast<double>(sample) / kSamples);
    for (std::size_t axis = 0; axis < fence_.side.size(); ++axis) {
      const double at = motion[axis].position_m, began = from[axis].position_m;
      if (at < std::min(fence_.side[axis].low_m, began) || at > std::max(fence_.side[axis].high_m, began)) {
        return false;
      }
    }
    if (length_of(motion, &Axis::velocity_m_s) > fastest || length_of(motion, &Axis::acceleration_m_s2) > strongest ||
        std::abs(motion[2].velocity_m_s) > climbs || std::abs(motion[kYawAxis].velocity_m_s) > turns) {
      return false;
    }
  }
  return true;
}

template class SetPointStream<float>;
template class SetPointStream<double>;

}  // namespace m100::companion
