// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/room/follow.h"

#include <sstream>

namespace m100::companion {

std::string goals_note(const ref::SpeedLimits& limits) {
  std::ostringstream text;
  text.precision(17);
  text << limits.speed_m_s << " " << limits.acceleration_m_s2 << " " << limits.yaw_rate_rad_s;
  return text.str();
}

std::optional<ref::SpeedLimits> limits_of_note(const std::string& note) {
  std::istringstream words(note);
  ref::SpeedLimits limits;
  words >> limits.speed_m_s >> limits.acceleration_m_s2 >> limits.yaw_rate_rad_s;
  return words ? std::optional(limits) : std::nullopt;
}

}  // namespace m100::companion
