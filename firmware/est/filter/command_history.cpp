// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/filter/command_history.h"

#include "firmware/core/maths.h"
#include "firmware/est/filter/reset_pose.h"
#include "firmware/est/filter/units.h"

namespace m100::est {

template <typename S, typename Real>
typename CommandHistory<S, Real>::Delay CommandHistory<S, Real>::delay_of(double delay_s) {
  const double ticks = delay_s > 0.0 ? delay_s / kTick_s : 0.0;
  Delay delay;
  delay.ticks = static_cast<std::size_t>(ticks + 1e-9);
  M100_ASSERT(delay.ticks + 3 < kCapacity);
  delay.rest = core::Arithmetic<S>::template number<double>(ticks - static_cast<double>(delay.ticks));
  return delay;
}

template <typename S, typename Real>
[[gnu::cold]] CommandHistory<S, Real>::CommandHistory(const model::Vehicle& vehicle)
    : delay_x_(delay_of(model::flown_pitch(vehicle).transport_delay_s)),
      delay_y_(delay_of(model::flown_roll(vehicle).transport_delay_s)),
      delay_climb_(delay_of(vehicle.climb.transport_delay_s)) {}

template <typename S, typename Real>
bool CommandHistory<S, Real>::store(const ctl::Command<Real>& command, const core::SinCos<Real>& heading) {
  const bool is_finite = finite(command.roll_rad) && finite(command.pitch_rad) && finite(command.climb_m_s);
  if (is_finite) {
    last_ = command;
  }
  const auto inside = [](Real angle_rad) {
    return core::clamp(angle_rad, Real(-kLargestAttitude_rad), Real(kLargestAttitude_rad));
  };
  const core::Tilt<Real> tilt = core::tilt_of(slope_.at(inside(last_.roll_rad), inside(last_.pitch_rad), heading));
  newest_ = (newest_ + 1) % kCapacity;
  past_[newest_] = {
      .x = core::Arithmetic<S>::template number<Real>(tilt.x_rad),
      .y = core::Arithmetic<S>::template number<Real>(tilt.y_rad),
      .climb = core::Arithmetic<S>::template number<Real>(last_.climb_m_s * static_cast<Real>(kTimeUnit_s))};
  return is_finite;
}

// With a delay of n + f ticks, a tick's mean command is f times that of n + 1 ticks ago plus 1 - f times that of n ago.
template <typename S, typename Real>
ActingInputs<S> CommandHistory<S, Real>::acting(const Delay& delay, S PastCommand::*axis) {
  auto& a = arithmetic_;
  const auto mixed = [&](std::size_t ago) {
    const S newer = past(ago).*axis;
    const S older = past(ago + 1).*axis;
    const S step = a.narrow(a.widen(older) - a.widen(newer));
    return a.narrow(a.widen(newer) + a.product(delay.rest, step));
  };
  return {.now = mixed(delay.ticks),
          .before = mixed(delay.ticks + 1),
          .after = mixed(delay.ticks > 0 ? delay.ticks - 1 : 0)};
}

template class CommandHistory<double, double>;
template class CommandHistory<float, float>;
template class CommandHistory<core::Fixed, float>;

}  // namespace m100::est
