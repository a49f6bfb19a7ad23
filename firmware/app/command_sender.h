// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/ctl/command.h"
#include "firmware/ctl/excitation.h"
#include "firmware/est/trim_monitor.h"
#include "firmware/link/serial_link.h"
#include "firmware/model/vehicle.h"
#include "firmware/safety/supervisor.h"
#include "firmware/vrc/command_map.h"
#include "protocol/dji/telemetry.h"

namespace m100::app {

/// Sends supervised commands as sticks or as movement commands. Computes the command that the aircraft obeys from the
/// sticks that were sent, or from the pilot's. T is float or double.
template <typename T>
class CommandSender {
 public:
  /// @param rule kAsThePaper: sticks sent count as the command that was wanted, as in the authors' program.
  CommandSender(const model::Vehicle& vehicle, link::Channel channel,
                vrc::StickRule rule = vrc::StickRule::kCarriesRemainder)
      : commands_(vehicle, rule), channel_(channel), rule_(rule) {}

  /// Once per tick, after the link received. @returns the command that the aircraft has obeyed since the last tick:
  /// ours (sticks: after rounding to counts), the pilot's if control is not ours, or level in the autopilot's own task.
  const ctl::Command<T>& update(bool in_control, const protocol::Telemetry& telemetry);

  /// Releases control if the supervisor demands it, and sends the supervised command if the link may carry one now.
  /// @param commanded the command before the supervisor.
  /// @returns as SerialLink::send, but kNotReady also if control is not ours; kRefused: the failsafe sends nothing.
  core::Status send(const safety::SupervisedCommand<T>& supervised, const ctl::Command<T>& commanded,
                    const ctl::Excitation<T>& excitation, link::SerialLink& link, core::TimePoint now);

  /// The command that the stick moved by the excitation gives, in SI units. Precondition: excitation.moves().
  T excited_command(const ctl::Excitation<T>& excitation) const;
  /// As CommandMap::set_learned_trims.
  void set_learned_trims(const est::TrimCounts<T>& learned) {
    commands_.set_learned_trims(static_cast<float>(learned.roll), static_cast<float>(learned.pitch));
  }
  /// Forgets the rounding error that the next sticks would compensate.
  void reset() { commands_.reset(); }
  bool uses_sticks() const { return channel_ == link::Channel::kVirtualRc; }
  /// The last sticks that were sent; centred before the first.
  const vrc::Sticks& sticks() const { return sticks_; }

 private:
  vrc::Stick excited_stick(const ctl::Excitation<T>& excitation) const;
  core::Status send_sticks(const safety::SupervisedCommand<T>& supervised, const ctl::Command<T>& commanded,
                           const ctl::Excitation<T>& excitation, link::SerialLink& link, core::TimePoint now);

  vrc::CommandMap commands_;
  link::Channel channel_;
  vrc::StickRule rule_;
  vrc::Sticks sticks_{};
  ctl::Command<T> applied_{};
};

extern template class CommandSender<float>;
extern template class CommandSender<double>;

}  // namespace m100::app
