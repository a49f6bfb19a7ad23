// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/body/body_plant.h"

#include <algorithm>

#include "firmware/companion/files/text/regular_file.h"
#include "firmware/companion/files/text/toml_text.h"
#include "firmware/companion/files/vehicle_keys.h"
#include "host_tests/sim/world/base_plant.h"

namespace m100::sim {
namespace {

using model::AxisUnit;

bool is_dynamics(std::string_view name) {
  const AxisUnit unit = name.starts_with("axis.climb")      ? AxisUnit::kClimb_m_s
                        : name.starts_with("axis.yaw_rate") ? AxisUnit::kYawRate_rad_s
                                                            : AxisUnit::kTilt_rad;
  const auto keys = companion::axis_keys(unit);
  const auto numbers = dynamics_numbers();
  return std::any_of(keys.begin(), keys.end(), [name, numbers](const companion::NumberKey<model::StickAxis>& key) {
    return key.key == name.substr(name.rfind('.') + 1) &&
           std::find(numbers.begin(), numbers.end(), key.member) != numbers.end();
  });
}

/// What the physics program has instead of this key.
const char* own_part(std::string_view name) {
  return name == "air.wind_m_s"                 ? "air; {wind} in --body-command hands this key on"
         : name.ends_with(".transport_delay_s") ? "dynamics; link.command_delay_s delays the commands"
         : name.starts_with("axis.")            ? "dynamics"
         : name.starts_with("air.")             ? "air"
                                                : "mass and motors";
}

/// Why the aircraft that flies does not have this key; empty: it has it. @param name the full name, without "change."
std::string why_ignored(const BodyChoice& body, std::string_view name) {
  if (body.is_identified()) {
    return name.starts_with("autopilot.") ? "belongs to a body, and none flies (--body, --body-command)" : "";
  }
  if (name == "air.wind_m_s" && body.passes_wind()) {
    return "";
  }
  const bool is_world = name.starts_with("air.") || name.starts_with("payload.") || name.starts_with("vehicle.");
  if (!is_world && name != "battery.sag" && !(name.starts_with("axis.") && is_dynamics(name))) {
    return "";
  }
  return std::string("has no effect on a body (--body, --body-command): its physics program has its own ") +
         own_part(name);
}

// Recurses as deep as tables are nested: at most companion::kMaxTomlDepth.
void refuse_ignored(const BodyChoice& body, const companion::TomlNode& table) {
  constexpr std::string_view kChange = "change.";
  for (const companion::TomlNode& node : table.entries()) {
    const std::string& name = node.name();
    if (node.is_table()) {
      refuse_ignored(body, node);
      continue;
    }
    if (node.key() == "source") {
      continue;
    }
    const bool changes = name.starts_with(kChange);
    const std::string why = why_ignored(body, std::string_view(name).substr(changes ? kChange.size() : 0));
    if (!why.empty()) {
      node.refuse(why);
    }
    if (changes && name.ends_with("air.wind_m_s") && !body.is_identified()) {
      node.refuse("cannot change: the physics program is given its wind at its start");
    }
  }
}

Plant base_of(const BodyChoice& body, const std::string& vehicle_path) {
  if (!vehicle_path.empty() && !body.is_identified()) {
    throw PhysicsError("--plant-from: has no effect on a body, which has its own dynamics, drag and thrust");
  }
  return base_plant(vehicle_path);
}

}  // namespace

Plant parse_plant(const BodyChoice& body, std::string_view text, const std::string& name,
                  const std::string& vehicle_path) {
  Plant plant = parse_plant(text, name, base_of(body, vehicle_path));
  refuse_ignored(body, companion::parse_toml(text, name));
  return plant;
}

Plant plant_of_options(const BodyChoice& body, const std::string& plant_path, const std::string& vehicle_path) {
  if (plant_path.empty()) {
    return base_of(body, vehicle_path);
  }
  const companion::FileContent content = companion::read_regular(plant_path, companion::kMaxTextBytes);
  if (!content.why_not.empty()) {
    throw companion::FileError(plant_path + ": " + content.why_not);
  }
  return parse_plant(body, content.bytes, plant_path, vehicle_path);
}

}  // namespace m100::sim
