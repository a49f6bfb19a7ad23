// SPDX-License-Identifier: BSD-3-Clause
// Sticks or movement commands that leave: from the granted command or an excitation's counts; keeps the sent command.
#include "firmware/app/flight_controller.h"
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

/// A stick of the RC item, -10000..10000, in counts.
vrc::Stick stick_of(std::int16_t rc) {
  constexpr auto kCentre = static_cast<int>(vrc::kStickCentre);
  constexpr int kTravel = static_cast<int>(vrc::kStickHigh) - kCentre;
  return within_travel(kCentre + (rc * kTravel + (rc < 0 ? -5000 : 5000)) / 10000);
}

}  // namespace

template <typename T, typename S>
ctl::Command<T> FlightController<T, S>::pilots_command(const protocol::Telemetry& telemetry) const {
  return cast<T>(commands_.to_command({.roll = stick_of(telemetry.rc.roll),
                                       .pitch = stick_of(telemetry.rc.pitch),
                                       .throttle = stick_of(telemetry.rc.throttle),
                                       .yaw = stick_of(telemetry.rc.yaw)}));
}

template <typename T, typename S>
vrc::Stick FlightController<T, S>::excited_stick() const {
  const vrc::StickMap& map = commands_.map(static_cast<std::size_t>(excitation_.axis()));
  const int counts = static_cast<int>(map.neutral_vrc + 0.5F) + excitation_.holding_counts() + excitation_.counts();
  return within_travel(counts);
}

template <typename T, typename S>
void FlightController<T, S>::excite(core::TimePoint now) {
  const bool may = supervisor_.failsafe_state() == safety::FailsafeState::kNominal && link_.authority().in_control;
  if (excitation_.returns()) {
    const est::TrimCounts<T> holding = trim_.holding(estimate_);
    excitation_.rest_at({.roll_counts = holding.roll, .pitch_counts = holding.pitch});
  }
  excitation_.update(estimate_, reference_, may, geofence_.brakes(), now);
  if (excitation_.moves()) {
    const auto axis = static_cast<std::size_t>(excitation_.axis());
    ctl::value_of(commanded_, axis) = static_cast<T>(commands_.map(axis).to_command(excited_stick()));
  }
}

/// The map compensates the dead zone and carries its rounding error over; an excitation sends its planned counts
/// instead, unless the supervisor limited them.
template <typename T, typename S>
vrc::Sticks FlightController<T, S>::excited(vrc::Sticks mapped) const {
  const auto axis = static_cast<std::size_t>(excitation_.axis());
  if (excitation_.moves() && ctl::value_of(supervised_.command, axis) == ctl::value_of(commanded_, axis)) {
    const std::array<vrc::Stick*, ctl::kStickAxes> all{&mapped.roll, &mapped.pitch, &mapped.throttle, &mapped.yaw};
    *all[axis] = excited_stick();
  }
  return mapped;
}

template <typename T, typename S>
core::Status FlightController<T, S>::send(const safety::SupervisedCommand<T>& grant, core::TimePoint now) {
  if (grant.release) {
    link_.release(now);
  }
  if (!grant.transmit) {
    return core::Status::kRefused;
  }
  return link_.due(now) ? send_command(grant.command, now) : core::Status::kNotReady;
}

template <typename T, typename S>
core::Status FlightController<T, S>::send_command(const ctl::Command<T>& command, core::TimePoint now) {
  if (config_.link.channel.channel == link::Channel::kMovement) {
    const core::Status sent = link_.send(cast<double>(command), now);
    applied_command_ = sent == core::Status::kOk ? command : applied_command_;
    return sent;
  }
  const core::Expected<vrc::Sticks> mapped = commands_.to_sticks(cast<float>(command));
  if (!mapped) {
    return mapped.status();
  }
  const vrc::Sticks sticks = excited(*mapped);
  const core::Status sent = link_.send(sticks, now);
  if (sent == core::Status::kOk) {
    last_sticks_ = sticks;
    applied_command_ = cast<T>(commands_.to_command(sticks));
  }
  return sent;
}

template void FlightController<double>::excite(core::TimePoint);
template void FlightController<float>::excite(core::TimePoint);
template void FlightController<float, core::Fixed>::excite(core::TimePoint);
template core::Status FlightController<double>::send(const safety::SupervisedCommand<double>&, core::TimePoint);
template core::Status FlightController<float>::send(const safety::SupervisedCommand<float>&, core::TimePoint);
template core::Status FlightController<float, core::Fixed>::send(const safety::SupervisedCommand<float>&,
                                                                 core::TimePoint);
template ctl::Command<double> FlightController<double>::pilots_command(const protocol::Telemetry&) const;
template ctl::Command<float> FlightController<float>::pilots_command(const protocol::Telemetry&) const;
template ctl::Command<float> FlightController<float, core::Fixed>::pilots_command(const protocol::Telemetry&) const;

}  // namespace m100::app
