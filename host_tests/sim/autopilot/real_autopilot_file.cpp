// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/autopilot/real_autopilot_file.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <sstream>
#include <vector>

#include "firmware/companion/files/text/toml_text.h"

namespace m100::sim {
namespace {

using B = N1Behaviour;
using Key = RealAutopilotKey;

constexpr std::array kSigns{-1.0, 1.0};
constexpr std::array kRequests{1.0, 2.0};
constexpr std::array kRates_hz{1.0, 10.0, 50.0, 100.0};

constexpr Key flag(std::string_view section, std::string_view key, bool& (*of)(B&)) {
  return {.section = section, .key = key, .flag = of};
}
constexpr Key number(std::string_view section, std::string_view key, double& (*of)(B&), double low, double high) {
  return {.section = section, .key = key, .number = of, .low = low, .high = high};
}
constexpr Key one_of(std::string_view section, std::string_view key, double& (*of)(B&),
                     std::span<const double> allowed) {
  return {
      .section = section, .key = key, .number = of, .low = allowed.front(), .high = allowed.back(), .allowed = allowed};
}

constexpr std::array kKeys{
    number(
        "answers", "delay_s", [](B& b) -> double& { return b.answers.delay_s; }, 0.0, 10.0),
    flag("answers", "needs_activation", [](B& b) -> bool& { return b.answers.needs_activation; }),
    flag("answers", "wrong_key_in_plain", [](B& b) -> bool& { return b.answers.wrong_key_in_plain; }),
    one_of(
        "control", "requests_to_obtain", [](B& b) -> double& { return b.control.requests_to_obtain; }, kRequests),
    one_of(
        "control", "requests_to_release", [](B& b) -> double& { return b.control.requests_to_release; }, kRequests),
    flag("control", "lost_push", [](B& b) -> bool& { return b.control.lost_push; }),
    flag("control", "returns_with_mode_f", [](B& b) -> bool& { return b.control.returns_with_mode_f; }),
    number(
        "virtual_rc", "timeout_s", [](B& b) -> double& { return b.virtual_rc.timeout_s; }, 0.05, 3600.0),
    flag("virtual_rc", "needs_control", [](B& b) -> bool& { return b.virtual_rc.needs_control; }),
    flag("virtual_rc", "end_gives_control_back", [](B& b) -> bool& { return b.virtual_rc.end_gives_control_back; }),
    flag("virtual_rc", "leaving_f_ends_it", [](B& b) -> bool& { return b.virtual_rc.leaving_f_ends_it; }),
    flag("virtual_rc", "shown_in_rc_item", [](B& b) -> bool& { return b.virtual_rc.shown_in_rc_item; }),
    flag("virtual_rc", "data_under_switch_id", [](B& b) -> bool& { return b.virtual_rc.data_under_switch_id; }),
    number(
        "virtual_rc", "full_deflection_counts", [](B& b) -> double& { return b.virtual_rc.full_deflection_counts; },
        100.0, 1024.0),
    one_of(
        "virtual_rc", "roll_sign", [](B& b) -> double& { return b.virtual_rc.roll_sign; }, kSigns),
    one_of(
        "virtual_rc", "pitch_sign", [](B& b) -> double& { return b.virtual_rc.pitch_sign; }, kSigns),
    one_of(
        "virtual_rc", "throttle_sign", [](B& b) -> double& { return b.virtual_rc.throttle_sign; }, kSigns),
    one_of(
        "virtual_rc", "yaw_sign", [](B& b) -> double& { return b.virtual_rc.yaw_sign; }, kSigns),
    number(
        "movement", "timeout_s", [](B& b) -> double& { return b.movement.timeout_s; }, 0.05, 3600.0),
    flag("movement", "timeout_gives_control_back", [](B& b) -> bool& { return b.movement.timeout_gives_control_back; }),
    one_of(
        "movement", "roll_sign", [](B& b) -> double& { return b.movement.roll_sign; }, kSigns),
    one_of(
        "movement", "pitch_sign", [](B& b) -> double& { return b.movement.pitch_sign; }, kSigns),
    one_of(
        "movement", "climb_sign", [](B& b) -> double& { return b.movement.climb_sign; }, kSigns),
    one_of(
        "movement", "yaw_sign", [](B& b) -> double& { return b.movement.yaw_sign; }, kSigns),
    flag("tasks", "offered", [](B& b) -> bool& { return b.tasks.offered; }),
    flag("tasks", "end_with_control", [](B& b) -> bool& { return b.tasks.end_with_control; }),
    number(
        "tasks", "take_off_height_m", [](B& b) -> double& { return b.tasks.take_off_height_m; }, 0.2, 5.0),
    number(
        "tasks", "take_off_climb_m_s", [](B& b) -> double& { return b.tasks.take_off_climb_m_s; }, 0.1, 4.0),
    number(
        "tasks", "landing_sink_m_s", [](B& b) -> double& { return b.tasks.landing_sink_m_s; }, 0.1, 4.0),
    flag("telemetry", "before_activation", [](B& b) -> bool& { return b.telemetry.before_activation; }),
    one_of(
        "telemetry", "rate_hz", [](B& b) -> double& { return b.telemetry.rate_hz; }, kRates_hz),
    flag("telemetry", "obeys_rates", [](B& b) -> bool& { return b.telemetry.obeys_rates; }),
    number(
        "telemetry", "acceleration_unit_m_s2", [](B& b) -> double& { return b.telemetry.acceleration_unit_m_s2; },
        0.001, 100.0),
    number(
        "telemetry", "silent_after_restart_s", [](B& b) -> double& { return b.telemetry.silent_after_restart_s; }, 0.0,
        60.0),
};

std::vector<Key> keys_of(std::string_view section) {
  std::vector<Key> out;
  std::copy_if(kKeys.begin(), kKeys.end(), std::back_inserter(out),
               [section](const Key& key) { return key.section == section; });
  return out;
}

void set(const Key& key, const companion::TomlNode& node, N1Behaviour& into) {
  if (key.flag != nullptr) {
    key.flag(into) = node.flag();
    return;
  }
  const double value = node.is(companion::TomlNode::Kind::kNumber) ? node.number() : key.low - 1.0;
  const bool is_allowed =
      key.allowed.empty() || std::find(key.allowed.begin(), key.allowed.end(), value) != key.allowed.end();
  if (!(value >= key.low && value <= key.high) || !is_allowed) {
    std::ostringstream range;
    range << "must be ";
    for (const double allowed : key.allowed) {
      range << (allowed == key.low ? "" : " or ") << allowed;
    }
    if (key.allowed.empty()) {
      range << "a number from " << key.low << " to " << key.high;
    }
    node.refuse(range.str());
  }
  key.number(into) = value;
}

}  // namespace

std::span<const RealAutopilotKey> real_autopilot_keys() { return kKeys; }

N1Behaviour parse_real_autopilot(std::string_view text, const std::string& name) {
  N1Behaviour out;
  const companion::TomlNode root = companion::parse_toml(text, name);
  for (const companion::TomlNode& section : root.entries()) {
    section.row_of(kKeys, &Key::section, "unknown section");
    const std::vector<Key> keys = keys_of(section.key());
    for (const companion::TomlNode& node : section.table().entries()) {
      set(node.row_of(keys, &Key::key), node, out);
    }
  }
  return out;
}

}  // namespace m100::sim
