// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>

#include "host_tests/lab/evening/folder.h"

namespace m100::lab::evening {

/// A channel of the vehicle file, with how pages call the error of its prediction.
struct Channel {
  const char* name;
  const char* words;
};
inline constexpr std::array<Channel, 4> kChannels{{{"roll", "roll [rad]"},
                                                   {"pitch", "pitch [rad]"},
                                                   {"climb", "climb speed [m/s]"},
                                                   {"yaw_rate", "yaw rate [rad/s]"}}};

/// Puts together what flies after the correction, corrected.toml: roll and pitch as tilts.toml has them, climb and yaw
/// rate as rates.toml has them where they predict the flight that moved throttle and yaw better than vehicle.toml does
/// (loop::predicts_better); else they stay. The fit has seen every other six seconds of that flight; what its few
/// numbers gain by fitting noise is a third of what is asked for. The course would not do: it hardly moves the
/// throttle. Notes "found.CHANNEL", 1 where climb or yaw rate were taken over, 0 where not, and "ahead.CHANNEL.before"
/// and ".after": the error 1 s ahead with vehicle.toml and corrected.toml on the first flight of the course, which no
/// fit has seen.
void take_over(Folder& folder);

}  // namespace m100::lab::evening
