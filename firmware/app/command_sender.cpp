// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/command_sender.h"

#include <array>

#include "firmware/core/maths.h"

namespace m100::app {
namespace {

template <typename To, typename From>
ctl::Command<To> cast(const ctl::Command<From>& command) {
  return {.roll_rad = static_cast<To>(command.roll_rad),
          .pitch_rad = static_cast<To>(command.pitch_rad),
          .climb_m_s = static_cast<To>(command.climb_m_s),
          .yaw_rate_rad_s = static_cast<To>(command.yaw_rate_rad_s)};
}

vrc::Stick within_travel(int counts) {
  return static_cast<vrc::Stick>(
      core::clamp(counts, static_cast<int>(vrc::kStickLow), static_cast<int>(vrc::kStickHigh)));
}

/// Converts a stick of the RC item, -10000..10000, to stick counts.
vrc::Stick stick_of(std::int16_t rc) {
  constexpr auto kCentre = static_cast<int>(vrc::kStickCentre);
  constexpr int kTravel = static_cast<int>(vrc::kStickHigh) - kCentre;
  return within_travel(kCentre + (rc * kTravel + (rc < 0 ? -5000 : 5000)) / 10000);
}

}  // namespace

template <typename T>
const ctl::Command<T>& CommandSender<T>::update(bool in_control, const protocol::Telemetry& telemetry) {
  if (!in_control) {
    applied_ = cast<T>(commands_.to_command({.roll = stick_of(telemetry.rc.roll),
                                             .pitch = stick_of(telemetry.rc.pitch),
                                             .throttle = stick_of(telemetry.rc.throttle),
                                             .yaw = stick_of(telemetry.rc.yaw)}));
  } else if (protocol::is_own_task(telemetry.flight_status)) {
    applied_ = {};
  }
  return applied_;
}

template <typename T>
vrc::Stick CommandSender<T>::excited_stick(const ctl::Excitation<T>& excitation) const {
  const vrc::StickMap& map = commands_.map(static_cast<std::size_t>(excitation.axis()));
  return within_travel(static_cast<int>(map.neutral_vrc + 0.5F) + excitation.holding_counts() + excitation.counts());
}

template <typename T>
T CommandSender<T>::excited_command(const ctl::Excitation<T>& excitation) const {
  const vrc::StickMap& map = commands_.map(static_cast<std::size_t>(excitation.axis()));
  return static_cast<T>(map.to_command(excited_stick(excitation)));
}

template <typename T>
core::Status CommandSender<T>::send(const safety::SupervisedCommand<T>& supervised, const ctl::Command<T>& commanded,
                                    const ctl::Excitation<T>& excitation, link::SerialLink& link, core::TimePoint now) {
  if (supervised.release) {
    link.release(now);
  }
  if (!supervised.transmit) {
    return core::Status::kRefused;
  }
  if (!link.due(now)) {
    return core::Status::kNotReady;
  }
  if (uses_sticks()) {
    return send_sticks(supervised, commanded, excitation, link, now);
  }
  const core::Status sent = link.send(cast<double>(supervised.command), now);
  applied_ = sent == core::Status::kOk ? supervised.command : applied_;
  return sent;
}

/// Sends the command as sticks. The stick that an excitation moves has the excitation's position instead, unless the
/// supervisor has changed the command of that axis.
template <typename T>
core::Status CommandSender<T>::send_sticks(const safety::SupervisedCommand<T>& supervised,
                                           const ctl::Command<T>& commanded, const ctl::Excitation<T>& excitation,
                                           link::SerialLink& link, core::TimePoint now) {
  const core::Expected<vrc::Sticks> mapped = commands_.to_sticks(cast<float>(supervised.command));
  if (!mapped) {
    return mapped.status();
  }
  vrc::Sticks sticks = *mapped;
  const auto axis = static_cast<std::size_t>(excitation.axis());
  if (excitation.moves() && ctl::value_of(supervised.command, axis) == ctl::value_of(commanded, axis)) {
    const std::array<vrc::Stick*, ctl::kStickAxes> all{&sticks.roll, &sticks.pitch, &sticks.throttle, &sticks.yaw};
    *all[axis] = excited_stick(excitation);
  }
  const core::Status sent = link.send(sticks, now);
  if (sent == core::Status::kOk) {
    sticks_ = sticks;
    applied_ = rule_ == vrc::StickRule::kAsThePaper ? supervised.command : cast<T>(commands_.to_command(sticks));
  }
  return sent;
}

template class CommandSender<float>;
template class CommandSender<double>;

}  // namespace m100::app
