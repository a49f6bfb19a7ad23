// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "host_tests/lab/evening/folder.h"
#include "host_tests/lab/identify/prediction.h"

namespace m100::lab::evening {

/// An axis of the vehicle file, and the words for its prediction error on pages.
struct VehicleAxis {
  const char* name;
  const char* words;
};
inline constexpr std::array<VehicleAxis, 5> kVehicleAxes{{{"roll", "roll [rad]"},
                                                          {"pitch", "pitch [rad]"},
                                                          {"climb", identify::kClimbByHeight},
                                                          {"yaw_rate", "yaw rate [rad/s]"},
                                                          {"translation", "horizontal velocity [m/s]"}}};

/// Writes corrected_model.toml, the corrected vehicle file before its weights are tuned. Roll and pitch come from
/// tilts.toml. Climb and yaw rate come from rates.toml, each only if it predicts the flight `excite_rates` better than
/// vehicle.toml and the flight `course` not worse. The drag comes from drag.toml only if it predicts `course` better
/// and its own flight leaves nothing unexplained. Records "found.CHANNEL" (climb, yaw_rate, translation; 1: taken over,
/// 0: not), and for each axis "ahead.AXIS.before" and ".after": the errors 1 s ahead with vehicle.toml and this file on
/// `course`.
void write_corrected_vehicle(Folder& folder);

}  // namespace m100::lab::evening
