// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/ground_station/guided_mode.h"

#include <sstream>

#include "firmware/companion/ground_station/return_to_start.h"

namespace m100::companion {

GuidedModeUpdate reject_goals(GroundStationTap& line) {
  GuidedModeUpdate outcome;
  outcome.order = line.take_order();
  if (line.take_goal()) {
    outcome.goal = GoalResult::kNotFlying;
  }
  return outcome;
}

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

std::string home_note(const ReturnSettings& settings) {
  std::ostringstream text;
  text.precision(17);
  text << settings.low_percent << " " << goals_note(settings.limits);
  return text.str();
}

std::optional<ReturnSettings> home_of_note(const std::string& note) {
  std::istringstream words(note);
  ReturnSettings settings;
  std::string limits;
  words >> settings.low_percent;
  std::getline(words, limits);
  const std::optional<ref::SpeedLimits> read = limits_of_note(limits);
  if (words.fail() || !read) {
    return std::nullopt;
  }
  settings.limits = *read;
  return settings;
}

}  // namespace m100::companion
