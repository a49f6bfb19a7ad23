// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/flight_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

#include "firmware/companion/files/flight_limits.h"
#include "firmware/companion/files/text/suggestion.h"
#include "firmware/companion/files/text/toml_text.h"
#include "firmware/link/pose/pose_link.h"

namespace m100::companion {
namespace {

constexpr double kFarthest_m = 1000.0;
constexpr double kLegalHeight_m = 122.0;  ///< 400 ft (14 CFR 107.51); the European Union allows 120 m
constexpr double kRoom_m = 0.5;           ///< least room on each side: half for a hover in wind, half for braking
constexpr double kLongestLever_m = 1.0;  ///< no pose's origin lies farther from an aircraft of 0.65 m between the axles
constexpr std::array kKeys{
    FlightKey{.section = "", .key = "mode", .mode = &FlightFile::mode},
    FlightKey{.section = "fence",
              .key = "x_m",
              .range = &FlightFile::fence_x_m,
              .low = -kFarthest_m,
              .high = kFarthest_m,
              .required = true},
    FlightKey{.section = "fence",
              .key = "y_m",
              .range = &FlightFile::fence_y_m,
              .low = -kFarthest_m,
              .high = kFarthest_m,
              .required = true},
    FlightKey{.section = "fence",
              .key = "z_m",
              .range = &FlightFile::fence_z_m,
              .low = -kFarthest_m,
              .high = kFarthest_m,
              .required = true},
    FlightKey{.section = "fence",
              .key = "ground_z_m",
              .number = &FlightFile::ground_z_m,
              .low = -kFarthest_m,
              .high = kFarthest_m},
    FlightKey{.section = "wind", .key = "class_m_s", .number = &FlightFile::wind_m_s, .low = 0.0, .high = 20.0},
    // Promise R3: a pose is fresh for at most 250 ms.
    FlightKey{.section = "pose", .key = "fresh_s", .number = &FlightFile::pose_fresh_s, .low = 0.02, .high = 0.25},
    // Above 1 s less fresh_s it has no effect: the observer abandons its prediction 1 s after the last pose.
    FlightKey{.section = "pose", .key = "coast_s", .number = &FlightFile::pose_coast_s, .low = 0.03, .high = 3.0},
    FlightKey{.section = "pose", .key = "level_s", .number = &FlightFile::pose_level_s, .low = 0.1, .high = 10.0},
    FlightKey{.section = "pose", .key = "from", .sender = &FlightFile::pose_from},
    FlightKey{.section = "pose", .key = "sigma_m", .number = &FlightFile::pose_sigma_m, .low = 1e-4, .high = 20.0},
    FlightKey{.section = "pose",
              .key = "offset_m",
              .vector = &FlightFile::pose_offset_m,
              .low = -kLongestLever_m,
              .high = kLongestLever_m},
    FlightKey{
        .section = "limits", .key = "speed_m_s", .number = &FlightFile::course_speed_m_s, .low = 0.1, .high = 20.0},
    FlightKey{.section = "limits",
              .key = "acceleration_m_s2",
              .number = &FlightFile::course_acceleration_m_s2,
              .low = 0.1,
              .high = 20.0},
    FlightKey{.section = "limits", .key = "tilt_deg", .number = &FlightFile::course_tilt_deg, .low = 1.0, .high = 25.0},
    FlightKey{.section = "limits",
              .key = "yaw_rate_deg_s",
              .number = &FlightFile::course_yaw_rate_deg_s,
              .low = 1.0,
              .high = 100.0},
    FlightKey{.section = "battery",
              .key = "low_percent",
              .number = &FlightFile::battery_low_percent,
              .low = 0.0,
              .high = 90.0},
};

std::string full_name(std::string_view section, std::string_view key) {
  return section.empty() ? std::string(key) : std::string(section) + "." + std::string(key);
}

std::string place(const std::string& file, const toml::node* node) {
  const auto line = node == nullptr ? 0U : node->source().begin.line;
  return file + (line > 0 ? ":" + std::to_string(line) : "");
}

[[noreturn]] void fail(const std::string& file, const toml::node* node, const std::string& key,
                       const std::string& what) {
  throw FlightFileError(place(file, node) + ": '" + key + "': " + what);
}

double number(const toml::node& node, const FlightKey& key, const std::string& file) {
  const std::string full = full_name(key.section, key.key);
  if (!node.is_number()) {
    fail(file, &node, full, key.range != nullptr ? "must be two numbers, the lower one first" : "must be a number");
  }
  const double value = *node.value<double>();
  if (!(value >= key.low && value <= key.high)) {
    fail(file, &node, full, text_of(value) + " is outside " + text_of(Range{key.low, key.high}));
  }
  return value;
}

Range range(const toml::node& node, const FlightKey& key, const std::string& file) {
  const toml::array* const pair = node.as_array();
  const std::string full = full_name(key.section, key.key);
  if (pair == nullptr || pair->size() != 2) {
    fail(file, &node, full, "must be two numbers, the lower one first");
  }
  const Range value{number((*pair)[0], key, file), number((*pair)[1], key, file)};
  if (!(value.low < value.high)) {
    fail(file, &node, full, "must be two numbers, the lower one first");
  }
  return value;
}

link::LeverArm vector(const toml::node& node, const FlightKey& key, const std::string& file) {
  const toml::array* const numbers = node.as_array();
  link::LeverArm value{};
  if (numbers == nullptr || numbers->size() != value.size()) {
    fail(file, &node, full_name(key.section, key.key), "must be three numbers: forward, left, up");
  }
  double squared = 0.0;
  for (std::size_t i = 0; i < value.size(); ++i) {
    const double one = number((*numbers)[i], key, file);
    value[i] = static_cast<float>(one);
    squared += one * one;
  }
  if (squared > key.high * key.high) {
    fail(file, &node, full_name(key.section, key.key), "is longer than " + text_of(key.high) + " m");
  }
  return value;
}

void take(const toml::node& node, const FlightKey& key, const std::string& file, FlightFile& into) {
  if (key.number != nullptr) {
    into.*key.number = number(node, key, file);
  } else if (key.range != nullptr) {
    into.*key.range = range(node, key, file);
  } else if (key.vector != nullptr) {
    into.*key.vector = vector(node, key, file);
  } else if (key.sender != nullptr) {
    into.*key.sender = sender_of(node.value<std::string>().value_or(""), place(file, &node) + ": 'pose.from'");
  } else {
    into.*key.mode = mode_of(node.value<std::string>().value_or(""), place(file, &node) + ": 'mode'");
  }
}

bool is_section(std::string_view word) {
  return std::any_of(kKeys.begin(), kKeys.end(), [&](const FlightKey& key) { return key.section == word; });
}

/// Suggests a key of the section instead of the unknown word. At the top of the file it also suggests section names.
std::string key_meant(std::string_view section, std::string_view word) {
  std::array<std::string_view, kKeys.size()> known;
  std::transform(kKeys.begin(), kKeys.end(), known.begin(), [section](const FlightKey& key) {
    return key.section == section ? key.key : section.empty() ? key.section : "";
  });
  return section.empty() ? section_meant(word, known) : did_you_mean(word, known);
}

/// Reads one table of the file; refuses a key without a row in kKeys.
void read_section(const toml::table& table, std::string_view section, const std::string& file, FlightFile& into) {
  for (const auto& [word, node] : table) {
    const FlightKey* const key = std::find_if(kKeys.begin(), kKeys.end(), [&, &name = word](const FlightKey& row) {
      return row.section == section && row.key == name.str();
    });
    if (key != kKeys.end()) {
      take(node, *key, file, into);
    } else if (section.empty() && is_section(word.str()) && node.is_table()) {
      read_section(*node.as_table(), word.str(), file, into);
    } else {
      fail(file, &node, full_name(section, word.str()),
           section.empty() && is_section(word.str()) ? "must be a table"
                                                     : "unknown key" + key_meant(section, word.str()));
    }
  }
}

void check_together(const toml::table& root, const std::string& file, const FlightFile& flight) {
  for (const FlightKey& key : kKeys) {
    const toml::node* const section = root.get(key.section);
    if (key.required && !root[key.section][key.key]) {
      fail(file, section, full_name(key.section, key.key), "is missing: nothing flies without a fence");
    }
  }
  for (const auto& [key, box] : {std::pair{"x_m", flight.fence_x_m}, std::pair{"y_m", flight.fence_y_m}}) {
    if (!box.contains(0.0)) {
      fail(file, root["fence"][key].node(), std::string("fence.") + key, "the start, 0, is not inside " + text_of(box));
    }
    if (box.low > -kRoom_m || box.high < kRoom_m) {
      fail(
          file, root["fence"][key].node(), std::string("fence.") + key,
          text_of(box) + " leaves less than " + text_of(kRoom_m) + " m on a side of the start: too narrow to hover in");
    }
  }
  if (flight.fence_z_m.high - flight.fence_z_m.low < 2.0 * kRoom_m) {
    fail(file, root["fence"]["z_m"].node(), "fence.z_m",
         text_of(flight.fence_z_m) + " is lower than " + text_of(2.0 * kRoom_m) + " m: too low to hover in");
  }
  if (flight.fence_z_m.low <= flight.ground_z_m) {
    fail(file, root["fence"]["z_m"].node(), "fence.z_m",
         "its floor is not above the ground at " + text_of(flight.ground_z_m) + " m ('fence.ground_z_m')");
  }
  if (flight.fence_z_m.high - flight.ground_z_m > kLegalHeight_m) {
    fail(file, root["fence"]["z_m"].node(), "fence.z_m",
         "reaches " + text_of(flight.fence_z_m.high - flight.ground_z_m) +
             " m above the ground, and no drone may fly above " + text_of(kLegalHeight_m) +
             " m; the fence is in metres, not in centimetres");
  }
  const safety::Limits limits = limits_of(flight);
  if (limits.coast <= limits.pose_fresh) {
    fail(file, root.get("pose"), "pose.coast_s", "must be longer than pose.fresh_s");
  }
  const auto most_m2 = link::PoseProperties::inside(fence_of(flight, {}), 0.0).max_variance_m2;
  const double largest_m = std::sqrt(*std::min_element(most_m2.begin(), most_m2.end()));
  if (flight.pose_sigma_m > largest_m) {
    fail(file, root["pose"]["sigma_m"].node(), "pose.sigma_m",
         "at most " + text_of(largest_m) +
             " m can be flown inside this fence: three sigmas reach from its middle to a side");
  }
}

}  // namespace

std::string text_of(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

std::string text_of(const Range& range) { return "[" + text_of(range.low) + ", " + text_of(range.high) + "]"; }

Mode mode_of(std::string_view word, const std::string& where) {
  if (const std::optional<Mode> mode = mode_named(present_mode_word(word))) {
    return *mode;
  }
  throw FlightFileError(where + ": must be \"field\" or \"robust\"" +
                        did_you_mean(word, kModes, [](Mode one) { return name(one); }));
}

link::SenderChoice sender_of(std::string_view word, const std::string& where) {
  const auto number = [](std::string_view text) {
    int value = -1;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc{} && end == text.data() + text.size() ? value : -1;
  };
  constexpr int kLargest = 255;
  const std::size_t colon = word.find(':');
  const int system = number(word.substr(0, colon));
  const int component = colon == std::string_view::npos ? 0 : number(word.substr(colon + 1));
  const bool named = colon == std::string_view::npos || component >= 1;
  if (system < 1 || system > kLargest || component < 0 || component > kLargest || !named) {
    throw FlightFileError(where + ": must be a sender's system, or system and component, as \"1\" or \"1:197\"");
  }
  return {.system = static_cast<std::uint8_t>(system), .component = static_cast<std::uint8_t>(component)};
}

std::span<const FlightKey> flight_keys() { return kKeys; }

FlightFile parse_flight(std::string_view text, const std::string& name) {
  toml::table root;
  try {
    root = parse_toml(text);
  } catch (const TomlTextError& wrong) {
    throw FlightFileError(name + ":" + std::to_string(wrong.line) + ": " + wrong.what());
  }
  FlightFile flight;
  read_section(root, "", name, flight);
  check_together(root, name, flight);
  return flight;
}

std::string describe_lever_arm(const FlightFile& flight) {
  const auto& [forward_m, left_m, up_m] = flight.pose_offset_m;
  std::ostringstream out;
  if (flight.pose_offset_m != link::LeverArm{}) {
    out << "the origin of the pose lies " << forward_m << " m ahead, " << left_m << " m left and " << up_m
        << " m above the centre of gravity ([pose] offset_m): what flies is the centre of gravity";
  }
  return out.str();
}

}  // namespace m100::companion
