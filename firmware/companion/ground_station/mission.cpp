// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/ground_station/mission.h"

#include <cmath>

#include "firmware/core/maths.h"

namespace m100::companion {
namespace {

constexpr double kMetresPerCount = 1e-4;  ///< of x and y in a local frame

double hold_s(const mavlink::MissionItemInt& item) {
  return std::isnan(item.param1) ? 0.0 : static_cast<double>(item.param1);
}

double radius_m(const mavlink::MissionItemInt& item) {
  return item.param2 > 0.F ? static_cast<double>(item.param2) : 0.0;
}

/// The item is passed without a stop.
bool is_passed(const mavlink::MissionItemInt& item) {
  return radius_m(item) > 0.0 && hold_s(item) == 0.0 && item.autocontinue != 0;
}

}  // namespace

template <typename T>
ref::Waypoint<T> place_of(const mavlink::MissionItemInt& item, T yaw_rad) {
  ref::Waypoint<T> place;
  place.position_w_m = {static_cast<T>(kMetresPerCount * item.x), static_cast<T>(-kMetresPerCount * item.y),
                        static_cast<T>(-item.z)};  // NED to NWU
  const double turn_rad = -static_cast<double>(item.param4) * core::kPi / 180.0;
  place.yaw_rad = std::isnan(item.param4) ? yaw_rad : core::wrap_pi(static_cast<T>(turn_rad));
  return place;
}

template <typename T>
bool Mission<T>::start(Items items, std::uint16_t first, std::uint16_t last, core::TimePoint now, bool flies) {
  if (!flies || first >= items.size()) {
    return false;
  }
  current_ = first_ = first;
  last_ = last_of(items, first, last);
  state_ = MissionState::kActive;
  fly_to_item(items[current_], now);
  return true;
}

template <typename T>
bool Mission<T>::resume(Items items, core::TimePoint now, bool flies) {
  if (!flies || state_ != MissionState::kPaused || current_ >= items.size()) {
    return false;
  }
  state_ = MissionState::kActive;
  fly_to_item(items[current_], now);
  return true;
}

template <typename T>
void Mission<T>::pause() {
  state_ = state_ == MissionState::kActive ? MissionState::kPaused : state_;
}

template <typename T>
void Mission<T>::reset(Items items) {
  state_ = items.empty() ? MissionState::kNone : MissionState::kNotStarted;
  current_ = 0;
}

template <typename T>
void Mission<T>::fly_to_item(const mavlink::MissionItemInt& item, core::TimePoint now) {
  reached_at_.reset();
  (void)goals_.fly_to(place_of<T>(item, goals_.yaw(now)), now);
}

template <typename T>
bool Mission<T>::is_reached(const mavlink::MissionItemInt& item, core::TimePoint now,
                            const est::Estimate<T>& estimate) const {
  const core::Vector<T, 3> place = goals_.clamp_to_fence(place_of<T>(item, T(0))).position_w_m;
  const core::Vector<T, 3> at{estimate.x.position_m, estimate.y.position_m, estimate.height_m};
  const double radius = radius_m(item) > 0.0 ? radius_m(item) : kRadius_m;
  const bool came =
      goals_.at_rest(now) || (is_passed(item) && static_cast<double>((goals_.reference(now) - place).norm()) <= radius);
  return came && static_cast<double>((at - place).norm()) <= radius;
}

template <typename T>
void Mission<T>::advance(Items items, core::TimePoint now) {
  const bool pauses = items[current_].autocontinue == 0;
  if (current_ >= last_) {
    state_ = MissionState::kComplete;
    return;
  }
  ++current_;
  if (pauses) {
    state_ = MissionState::kPaused;
    return;
  }
  fly_to_item(items[current_], now);
}

template <typename T>
std::optional<std::uint16_t> Mission<T>::update(Items items, core::TimePoint now, const est::Estimate<T>& estimate,
                                                bool flies) {
  if (!flies) {
    pause();
  }
  if (state_ != MissionState::kActive || current_ >= items.size()) {
    return {};
  }
  const mavlink::MissionItemInt& item = items[current_];
  const std::uint16_t reached = current_;
  const bool is_new = !reached_at_ && is_reached(item, now, estimate);
  if (is_new) {
    reached_at_ = now;
  }
  if (reached_at_ && core::seconds<double>(now - *reached_at_) >= hold_s(item)) {
    advance(items, now);
  }
  return is_new ? std::optional(reached) : std::nullopt;
}

template class Mission<float>;
template class Mission<double>;
template ref::Waypoint<float> place_of(const mavlink::MissionItemInt&, float);
template ref::Waypoint<double> place_of(const mavlink::MissionItemInt&, double);

}  // namespace m100::companion
