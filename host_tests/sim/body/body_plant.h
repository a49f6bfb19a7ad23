// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "host_tests/sim/body/body_choice.h"

namespace m100::sim {

/// The plant of a command line for the aircraft that flies. A body has its own dynamics, air and mass, so a key of
/// these, which would be ignored, is refused, and --plant-from too. It has the sticks of [axis.*] (also in [change]),
/// [pose], [sensors], [link], [autopilot], battery.start_percent, and air.wind_m_s where its command has {wind}. The
/// identified response has all but [autopilot].
/// @throws companion::FileError with file, line and key; PhysicsError for --plant-from;
Plant plant_of_options(const BodyChoice& body, const std::string& plant_path, const std::string& vehicle_path);
/// The same from a text; `name` stands for the file in messages.
Plant parse_plant(const BodyChoice& body, std::string_view text, const std::string& name,
                  const std::string& vehicle_path);

}  // namespace m100::sim
