// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/room/follow.h"

#include <sstream>

#include "firmware/companion/room/homeward.h"

namespace m100::companion {

Followed decline(OverheardLine& line) {
  Followed followed;
  followed.order = line.take_order();
  if (line.take_goal()) {
    followed.goal = GoalAnswer::kNotFlying;
  }
  for (const Request& request : line.requests()) {
    const mavlink::Address to = request.from;
    const auto refuse = [&](std::uint8_t result) {
      (void)followed.replies.add(
          mavlink::MissionAck{.target_system = to.system, .target_component = to.component, .type = result});
    };
    if (std::holds_alternative<mavlink::MissionCount>(request.message) ||
        std::holds_alternative<mavlink::MissionClearAll>(request.message)) {
      refuse(mission_result::kDenied);
    } else if (std::holds_alternative<mavlink::MissionRequestInt>(request.message)) {
      refuse(mission_result::kInvalidSequence);
    } else if (std::holds_alternative<mavlink::MissionRequestList>(request.message)) {
      (void)followed.replies.add(
          mavlink::MissionCount{.count = 0, .target_system = to.system, .target_component = to.component});
    }
  }
  line.forget_requests();
  return followed;
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

std::string home_note(const HomeSettings& settings) {
  std::ostringstream text;
  text.precision(17);
  text << settings.low_percent << " " << goals_note(settings.limits);
  return text.str();
}

std::optional<HomeSettings> home_of_note(const std::string& note) {
  std::istringstream words(note);
  HomeSettings settings;
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
