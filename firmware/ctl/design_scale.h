// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/ctl/command.h"
#include "firmware/model/vehicle.h"

namespace m100::ctl {

/// Converts the tilts of commands between two scales (rad per count): the identified one, with which the stick map
/// converts, and the one of [design]. If the design's is 5 % larger, the law assumes that sent counts tilt the aircraft
/// by 5 % more than the stick map says, and fewer counts are sent for its commands. On an axis without a scale in
/// [design], and on a channel without sticks, the factor is 1 and no bit changes.
template <typename T>
class DesignScale {
 public:
  DesignScale(const model::Vehicle& vehicle, bool by_sticks)
      : roll_(ratio(vehicle.design.roll, vehicle.roll, by_sticks)),
        pitch_(ratio(vehicle.design.pitch, vehicle.pitch, by_sticks)) {}

  /// A sent command, on the scale of the design.
  Command<T> expected(Command<T> command) const {
    command.roll_rad *= roll_;
    command.pitch_rad *= pitch_;
    return command;
  }
  /// The command to send for a command of the design.
  Command<T> to_send(Command<T> command) const {
    command.roll_rad /= roll_;
    command.pitch_rad /= pitch_;
    return command;
  }

 private:
  static T ratio(const model::StickAxis& design, const model::StickAxis& identified, bool by_sticks) {
    const bool known = by_sticks && design.scale_per_count > 0.0 && identified.scale_per_count > 0.0;
    return known ? static_cast<T>(design.scale_per_count / identified.scale_per_count) : T(1);
  }

  T roll_;
  T pitch_;
};

}  // namespace m100::ctl
