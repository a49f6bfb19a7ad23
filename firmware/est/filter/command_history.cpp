// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/filter/command_history.h"

#include "firmware/core/maths.h"

namespace m100::est {

template <typename T>
typename CommandHistory<T>::Delay CommandHistory<T>::delay_of(double delay_s) {
  const double ticks = delay_s > 0.0 ? delay_s / kTick_s : 0.0;
  Delay delay;
  delay.ticks = static_cast<std::size_t>(ticks + 1e-9);
  M100_ASSERT(delay.ticks + 3 < kCapacity);
  delay.rest = static_cast<T>(ticks - static_cast<double>(delay.ticks));
  return delay;
}

template <typename T>
[[gnu::cold]] CommandHistory<T>::CommandHistory(const model::Vehicle& vehicle)
    : delay_x_(delay_of(model::flown_pitch(vehicle).transport_delay_s)),
      delay_y_(delay_of(model::flown_roll(vehicle).transport_delay_s)),
      delay_climb_(delay_of(vehicle.climb.transport_delay_s)) {}

template <typename T>
bool CommandHistory<T>::store(const ctl::Command<T>& command, const core::SinCos<T>& heading) {
  const T sum = command.roll_rad + command.pitch_rad + command.climb_m_s;
  const bool is_finite = sum - sum == T(0);
  if (is_finite) {
    last_ = command;
  }
  const auto inside = [](T angle_rad) {
    return core::clamp(angle_rad, T(-kLargestAttitude_rad), T(kLargestAttitude_rad));
  };
  const core::Tilt<T> tilt = core::tilt_of(slope_.at(inside(last_.roll_rad), inside(last_.pitch_rad), heading));
  newest_ = (newest_ + 1) % kCapacity;
  past_[newest_] = {.x = tilt.x_rad, .y = tilt.y_rad, .climb = last_.climb_m_s};
  return is_finite;
}

// With a delay of n + f ticks, a tick's mean command is f times that of n + 1 ticks ago plus 1 - f times that of n ago.
template <typename T>
ActingInputs<T> CommandHistory<T>::acting(const Delay& delay, T PastCommand::*axis) const {
  const auto past = [&](std::size_t ago) { return past_[(newest_ + kCapacity - ago) % kCapacity].*axis; };
  const auto mixed = [&](std::size_t ago) { return past(ago) + delay.rest * (past(ago + 1) - past(ago)); };
  return {.now = mixed(delay.ticks),
          .before = mixed(delay.ticks + 1),
          .after = mixed(delay.ticks > 0 ? delay.ticks - 1 : 0)};
}

template class CommandHistory<double>;
template class CommandHistory<float>;

}  // namespace m100::est
