// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ref/time_optimal.h"

#include <algorithm>
#include <utility>

#include "firmware/core/assert.h"
#include "firmware/core/maths.h"

namespace m100::ref {
namespace {

template <typename T>
constexpr T kTolerance_m = static_cast<T>(sizeof(T) == sizeof(float) ? 2e-5 : 1e-9);

template <typename T>
AxisReference<T> mirrored(const AxisReference<T>& state) {
  return {.position_m = -state.position_m,
          .velocity_m_s = -state.velocity_m_s,
          .acceleration_m_s2 = -state.acceleration_m_s2};
}

template <typename T>
AxisLimits<T> mirrored(AxisLimits<T> limits) {
  std::swap(limits.up_m_s2, limits.down_m_s2);
  return limits;
}

}  // namespace

/// Searches the peak of the acceleration in coordinates relative to the goal. They are mirrored if an immediate stop
/// would end above the goal.
template <typename T>
class TimeOptimal<T>::Search {
 public:
  Search(const AxisReference<T>& from, const AxisLimits<T>& limits)
      : from_(from),
        jerk_m_s3_(limits.jerk_m_s3),
        release_m_s3_(limits.release_m_s3),
        peak_m_s2_(std::max(limits.up_m_s2, from.acceleration_m_s2)),
        braking_m_s2_(std::max(limits.braking_share * limits.down_m_s2, -from.acceleration_m_s2)),
        speed_m_s_(limits.speed_m_s) {
    if (stops_upwards(from)) {  // it moves downwards, so the motion begins by braking
      peak_m_s2_ = std::max(limits.braking_share * limits.up_m_s2, from.acceleration_m_s2);
    }
  }

  /// Whether braking to rest at once, wherever that is, begins by raising the acceleration.
  bool stops_upwards(const AxisReference<T>& state) const { return level_speed(state) < T(0); }

  /// Where the aircraft comes to rest if it brakes at once. Requires !stops_upwards().
  T stop_m() const { return stopped(from_, nullptr); }

  void run(Piece* pieces) {
    const T a0 = from_.acceleration_m_s2;
    const T base_m_s = from_.velocity_m_s - T(0.5) * a0 * a0 / jerk_m_s3_;  // level speed = base + peak^2 / jerk
    const bool upwards = stops_upwards(from_);
    const T turning_m_s2 = core::sqrt(-base_m_s * ramps_m_s3());
    const T least = upwards && base_m_s < T(0) ? std::min(std::max(turning_m_s2, a0), peak_m_s2_) : a0;
    const T by_speed = std::max(core::sqrt(jerk_m_s3_ * (speed_m_s_ - base_m_s)), least);
    const T most = std::min(peak_m_s2_, by_speed);
    const T level_m_s = base_m_s + peak_m_s2_ * peak_m_s2_ / jerk_m_s3_;
    const T turned_m_s = base_m_s + peak_m_s2_ * peak_m_s2_ / ramps_m_s3();
    const T least_hold_s = upwards ? std::max(-turned_m_s / peak_m_s2_, T(0)) : T(0);
    if (end_m(most, least_hold_s) >= T(0)) {
      peak_ = find(least, most, [this, least_hold_s](T peak) { return end_m(peak, least_hold_s); });
      hold_s_ = least_hold_s;
    } else {
      peak_ = most;
      const T most_hold_s =
          by_speed < peak_m_s2_ ? T(0) : std::max((speed_m_s_ - level_m_s) / peak_m_s2_, least_hold_s);
      const T short_m = -end_m(peak_, most_hold_s);
      if (short_m > T(0)) {
        hold_s_ = most_hold_s;
        const AxisReference<T> top = risen(peak_, hold_s_, nullptr);
        const T cruising_m_s = top.velocity_m_s + T(0.5) * top.acceleration_m_s2 * top.acceleration_m_s2 / jerk_m_s3_;
        cruise_s_ = cruising_m_s > T(0) ? short_m / cruising_m_s : T(0);
      } else {
        hold_s_ = find(least_hold_s, most_hold_s, [this](T hold_s) { return end_m(peak_, hold_s); });
      }
    }
    write(pieces);
  }

 private:
  T level_speed(const AxisReference<T>& state) const {
    const T a = state.acceleration_m_s2;
    return state.velocity_m_s + T(0.5) * a * (a < T(0) ? -a : a) / release_m_s3_;
  }
  /// An acceleration that goes to a peak at jerk_m_s3_ and back at release_m_s3_ changes the speed by peak^2 over this.
  T ramps_m_s3() const { return T(2) * jerk_m_s3_ * release_m_s3_ / (jerk_m_s3_ + release_m_s3_); }
  /// The state after the rise to `peak` and its hold.
  AxisReference<T> risen(T peak, T hold_s, Piece* pieces) const {
    const T rise_s = std::max((peak - from_.acceleration_m_s2) / jerk_m_s3_, T(0));
    if (pieces != nullptr) {
      pieces[0] = {rise_s, jerk_m_s3_};
      pieces[1] = {hold_s, T(0)};
    }
    return after(after(from_, rise_s, jerk_m_s3_), hold_s, T(0));
  }
  /// The position of rest after a stop that begins by lowering the acceleration.
  T stopped(const AxisReference<T>& state, Piece* pieces) const {
    const T a = state.acceleration_m_s2;
    const T level_m_s = state.velocity_m_s + T(0.5) * a * a / jerk_m_s3_;
    // If jerk_m_s3_ would bring the acceleration to zero before the speed, a lower jerk brings both there together.
    const T fall_m_s3 = level_m_s < T(0) ? T(-0.5) * a * a / state.velocity_m_s : jerk_m_s3_;
    T trough = core::sqrt(level_m_s * ramps_m_s3());
    T hold_s = T(0);
    T release_m_s3 = release_m_s3_;
    if (a < T(0) && stops_upwards(state)) {  // brakes too hard already: the braking ends at a higher jerk
      trough = -a;
      release_m_s3 = state.velocity_m_s > T(0) ? std::min(T(0.5) * a * a / state.velocity_m_s, jerk_m_s3_) : jerk_m_s3_;
    } else if (trough > braking_m_s2_) {
      trough = braking_m_s2_;
      hold_s = level_m_s / trough - trough / ramps_m_s3();
    }
    const T fall_s = std::max((a + trough) / fall_m_s3, T(0));
    const T rise_s = trough / release_m_s3;
    if (pieces != nullptr) {
      pieces[0] = {fall_s, -fall_m_s3};
      pieces[1] = {hold_s, T(0)};
      pieces[2] = {rise_s, release_m_s3};
    }
    return after(after(after(state, fall_s, -fall_m_s3), hold_s, T(0)), rise_s, release_m_s3).position_m;
  }
  T end_m(T peak, T hold_s) const { return stopped(risen(peak, hold_s, nullptr), nullptr); }

  /// The zero of a rising function, or `low` if the function is not negative there: regula falsi, Illinois variant.
  template <typename F>
  static T find(T low, T high, F function) {
    T at_low = function(low), at_high = function(high);
    if (!(at_low < T(0))) {
      return low;
    }
    int kept = 0;
    T middle = high;
    for (int step = 0; step < kMaxSteps && high > low; ++step) {
      const T share = at_high / (at_high - at_low);
      middle = high - share * (high - low);
      const T at_middle = function(middle);
      if (at_middle < kTolerance_m<T> && at_middle > -kTolerance_m<T>) {
        break;
      }
      if (at_middle < T(0)) {
        low = middle;
        at_low = at_middle;
        at_high *= kept < 0 ? T(0.5) : T(1);
        kept = -1;
      } else {
        high = middle;
        at_high = at_middle;
        at_low *= kept > 0 ? T(0.5) : T(1);
        kept = 1;
      }
    }
    return middle;
  }

  void write(Piece* pieces) const {
    AxisReference<T> state = risen(peak_, hold_s_, pieces);
    if (cruise_s_ > T(0)) {
      const T level_s = state.acceleration_m_s2 / jerk_m_s3_;
      state = after(after(state, level_s, -jerk_m_s3_), cruise_s_, T(0));
      pieces[2] = {level_s, -jerk_m_s3_};
      pieces[3] = {cruise_s_, T(0)};
    }
    static_cast<void>(stopped(state, pieces + 4));
  }

  const AxisReference<T>& from_;
  T jerk_m_s3_, release_m_s3_, peak_m_s2_, braking_m_s2_, speed_m_s_;
  T peak_{0}, hold_s_{0}, cruise_s_{0};
};

/// Evaluates the motion at ascending times.
template <typename T>
class TimeOptimal<T>::Walk {
 public:
  explicit Walk(const TimeOptimal& motion) : motion_(motion), state_(motion.from_) {}
  AxisReference<T> to(T time_s) {
    if (time_s >= motion_.duration_s_) {
      return {.position_m = motion_.goal_m_};
    }
    while (piece_ + 1 < kPieces && time_s - begin_s_ >= motion_.pieces_[piece_].duration_s) {
      const Piece& over = motion_.pieces_[piece_];
      state_ = after(state_, over.duration_s, over.jerk_m_s3);
      begin_s_ += over.duration_s;
      ++piece_;
    }
    AxisReference<T> now = after(state_, time_s - begin_s_, motion_.pieces_[piece_].jerk_m_s3);
    now.position_m += motion_.goal_m_;
    return now;
  }

 private:
  const TimeOptimal& motion_;
  AxisReference<T> state_;
  T begin_s_{0};
  std::size_t piece_ = 0;
};

template <typename T>
void TimeOptimal<T>::rest(T goal_m) {
  goal_m_ = goal_m;
  duration_s_ = T(0);
}

/// The piece that brings an acceleration beyond its limit back to it.
template <typename T>
typename TimeOptimal<T>::Piece TimeOptimal<T>::back_to_limits(T acceleration_m_s2, const AxisLimits<T>& limits) {
  const T beyond_m_s2 = acceleration_m_s2 - core::clamp(acceleration_m_s2, -limits.down_m_s2, limits.up_m_s2);
  return {(beyond_m_s2 < T(0) ? -beyond_m_s2 : beyond_m_s2) / limits.jerk_m_s3,
          beyond_m_s2 > T(0) ? -limits.jerk_m_s3 : limits.jerk_m_s3};
}

template <typename T>
T TimeOptimal<T>::stop_m(const AxisReference<T>& from, const AxisLimits<T>& limits) {
  const Piece back = back_to_limits(from.acceleration_m_s2, limits);
  const AxisReference<T> begin = after(from, back.duration_s, back.jerk_m_s3);
  const Search up(begin, limits);
  if (!up.stops_upwards(begin)) {
    return up.stop_m();
  }
  const AxisReference<T> turned = mirrored(begin);
  return -Search(turned, mirrored(limits)).stop_m();
}

template <typename T>
void TimeOptimal<T>::plan(const AxisReference<T>& from, T goal_m, const AxisLimits<T>& limits) {
  M100_ASSERT(limits.up_m_s2 > T(0) && limits.down_m_s2 > T(0) && limits.release_m_s3 > T(0) &&
              limits.speed_m_s > T(0) && limits.braking_share > T(0) && limits.jerk_m_s3 >= limits.release_m_s3);
  goal_m_ = goal_m;
  from_ = from;
  from_.position_m -= goal_m;
  pieces_ = {};
  pieces_[0] = back_to_limits(from.acceleration_m_s2, limits);
  const AxisReference<T> begin = after(from_, pieces_[0].duration_s, pieces_[0].jerk_m_s3);
  const bool goes_up = stop_m(from_, limits) < T(0);
  const AxisReference<T> start = goes_up ? begin : mirrored(begin);
  Search(start, goes_up ? limits : mirrored(limits)).run(pieces_.data() + 1);
  duration_s_ = T(0);
  for (std::size_t i = 0; i < kPieces; ++i) {
    duration_s_ += pieces_[i].duration_s;
    if (i > 0 && !goes_up) {
      pieces_[i].jerk_m_s3 = -pieces_[i].jerk_m_s3;
    }
  }
}

template <typename T>
AxisReference<T> TimeOptimal<T>::at(T time_s) const {
  return Walk(*this).to(time_s);
}

template <typename T>
void TimeOptimal<T>::fill(std::span<AxisReference<T>> window, T first_s) const {
  Walk walk(*this);
  for (std::size_t k = 0; k < window.size(); ++k) {
    window[k] = walk.to(first_s + static_cast<T>(k) * static_cast<T>(kPredictionStep_s));
  }
}

template class TimeOptimal<float>;
template class TimeOptimal<double>;

}  // namespace m100::ref
