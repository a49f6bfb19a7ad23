// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/ground_station/guided_mode.h"

#include <sstream>

#include "firmware/companion/ground_station/return_to_start.h"

namespace m100::companion {

GuidedModeUpdate reject_goals(GroundStationTap& line) {
  GuidedModeUpdate outcome;
  outcome.order = line.take_order();
  outcome.goal = line.take_stranger() ? std::optional(GoalResult::kUnsigned) : std::nullopt;
  while (line.take_goal()) {
    outcome.goal = GoalResult::kNotFlying;
  }
  return outcome;
}

std::string goals_note(const GoalSettings& settings) {
  const ref::SpeedLimits& limits = settings.limits;
  std::ostringstream text;
  text.precision(17);
  text << limits.speed_m_s << " " << limits.acceleration_m_s2 << " " << limits.yaw_rate_rad_s;
  if (settings.stream) {
    text << " stream " << settings.stream->speed_m_s << " " << settings.stream->acceleration_m_s2 << " "
         << settings.stream->climb_m_s << " " << settings.stream->yaw_rate_rad_s;
  }
  if (settings.only) {
    text << " from " << +settings.only->system << " " << +settings.only->component;
  }
  return text.str();
}

std::optional<GoalSettings> goals_of_note(const std::string& note) {
  std::istringstream words(note);
  GoalSettings settings;
  words >> settings.limits.speed_m_s >> settings.limits.acceleration_m_s2 >> settings.limits.yaw_rate_rad_s;
  bool is_read = !words.fail();
  for (std::string word; is_read && words >> word;) {
    if (word == "stream") {
      StreamLimits& stream = settings.stream.emplace();
      words >> stream.speed_m_s >> stream.acceleration_m_s2 >> stream.climb_m_s >> stream.yaw_rate_rad_s;
    } else if (word == "from") {
      unsigned system = 0, component = 0;
      words >> system >> component;
      settings.only = {.system = static_cast<std::uint8_t>(system), .component = static_cast<std::uint8_t>(component)};
    } else {
      return std::nullopt;
    }
    is_read = !words.fail();
  }
  return is_read ? std::optional(settings) : std::nullopt;
}

std::string home_note(const ReturnSettings& settings) {
  std::ostringstream text;
  text.precision(17);
  text << settings.low_percent << " " << goals_note({.limits = settings.limits});
  return text.str();
}

std::optional<ReturnSettings> home_of_note(const std::string& note) {
  std::istringstream words(note);
  ReturnSettings settings;
  std::string limits;
  words >> settings.low_percent;
  std::getline(words, limits);
  const std::optional<GoalSettings> read = goals_of_note(limits);
  if (words.fail() || !read) {
    return std::nullopt;
  }
  settings.limits = read->limits;
  return settings;
}

}  // namespace m100::companion
