// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/ctl/command.h"
#include "firmware/model/vehicle.h"

namespace m100::ctl {

/// Converts the tilts of commands between two scales (rad per count) of the tilt sticks. The identified scale is the
/// one of the stick map; the scale of [design] is the one that the control law assumes. The factor is 1 without sticks,
/// and on an axis without a scale in [design].
template <typename T>
class DesignScale {
 public:
  DesignScale(const model::Vehicle& vehicle, bool by_sticks)
      : roll_(ratio(vehicle.design.roll, vehicle.roll, by_sticks)),
        pitch_(ratio(vehicle.design.pitch, vehicle.pitch, by_sticks)) {}

  /// Converts a sent command to the scale of the design.
  Command<T> expected(Command<T> command) const {
    command.roll_rad *= roll_;
    command.pitch_rad *= pitch_;
    return command;
  }
  /// Converts a command of the design to the one to send.
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
