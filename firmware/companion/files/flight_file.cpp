// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/flight_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <set>
#include <sstream>
#include <vector>

#include "firmware/companion/files/flight_limits.h"
#include "firmware/companion/files/text/toml_text.h"
#include "firmware/link/pose/pose_link.h"

namespace m100::companion {
namespace {

constexpr double kFarthest_m = 1000.0;
constexpr double kLegalHeight_m = 122.0;  ///< 400 ft (14 CFR 107.51); the European Union allows 120 m
constexpr double kRoom_m = 0.5;           ///< least room on each side: half for a hover in wind, half for braking
constexpr double kLongestLever_m = 1.0;  ///< no pose's origin lies farther from an aircraft of 0.65 m between the axles
using F = FlightFile;
constexpr std::array kKeys{
    FlightKey{"", "mode", &F::mode},
    FlightKey{"fence", "x_m", &F::fence_x_m, -kFarthest_m, kFarthest_m, true},
    FlightKey{"fence", "y_m", &F::fence_y_m, -kFarthest_m, kFarthest_m, true},
    FlightKey{"fence", "z_m", &F::fence_z_m, -kFarthest_m, kFarthest_m, true},
    FlightKey{"fence", "ground_z_m", &F::ground_z_m, -kFarthest_m, kFarthest_m},
    FlightKey{"wind", "class_m_s", &F::wind_m_s, 0.0, 20.0},
    // Promise R3: a pose is fresh for at most 250 ms.
    FlightKey{"pose", "fresh_s", &F::pose_fresh_s, 0.02, 0.25},
    // Above 1 s less fresh_s it has no effect: the observer abandons its prediction 1 s after the last pose.
    FlightKey{"pose", "coast_s", &F::pose_coast_s, 0.03, 3.0},
    FlightKey{"pose", "level_s", &F::pose_level_s, 0.1, 10.0},
    FlightKey{"pose", "from", &F::pose_from},
    FlightKey{"pose", "sigma_m", &F::pose_sigma_m, 1e-4, 20.0},
    FlightKey{"pose", "offset_m", &F::pose_offset_m, -kLongestLever_m, kLongestLever_m},
    FlightKey{"limits", "speed_m_s", &F::course_speed_m_s, 0.1, 20.0},
    FlightKey{"limits", "acceleration_m_s2", &F::course_acceleration_m_s2, 0.1, 20.0},
    FlightKey{"limits", "tilt_deg", &F::course_tilt_deg, 1.0, 25.0},
    FlightKey{"limits", "yaw_rate_deg_s", &F::course_yaw_rate_deg_s, 1.0, 100.0},
    FlightKey{"battery", "low_percent", &F::battery_low_percent, 0.0, 90.0},
};

std::string place_of(const TomlNode& node, const std::string& file) {
  return file + ":" + std::to_string(node.line()) + ": '" + node.name() + "'";
}

// One reader for each type of member.
void read(const TomlNode& node, const FlightKey& key, const std::string&, double& into) {
  into = node.number(key.low, key.high);
}
void read(const TomlNode& node, const FlightKey& key, const std::string&, Range& into) {
  const std::vector<TomlNode>& pair = node.entries();
  const bool numbers =
      std::all_of(pair.begin(), pair.end(), [](const auto& one) { return one.is(TomlNode::Kind::kNumber); });
  if (node.is_array() && pair.size() == 2 && numbers) {
    into = {pair[0].number(key.low, key.high), pair[1].number(key.low, key.high)};
  }
  if (!(into.low < into.high)) {
    node.refuse("must be two numbers, the lower one first");
  }
}
void read(const TomlNode& node, const FlightKey& key, const std::string&, link::LeverArm& into) {
  if (!node.is_array() || node.entries().size() != into.size()) {
    node.refuse("must be three numbers: forward, left, up");
  }
  double squared = 0.0;
  for (std::size_t i = 0; i < into.size(); ++i) {
    const double one = node.entries()[i].number(key.low, key.high);
    into[i] = static_cast<float>(one);
    squared += one * one;
  }
  if (squared > key.high * key.high) {
    node.refuse("is longer than " + text_of(key.high) + " m");
  }
}
void read(const TomlNode& node, const FlightKey&, const std::string& file, link::SenderChoice& into) {
  into = sender_of(node.text(), place_of(node, file));
}
void read(const TomlNode& node, const FlightKey&, const std::string& file, Mode& into) {
  into = mode_of(node.text(), place_of(node, file));
}

std::vector<FlightKey> keys_of(std::string_view section) {
  std::vector<FlightKey> out;
  std::copy_if(kKeys.begin(), kKeys.end(), std::back_inserter(out),
               [section](const FlightKey& key) { return key.section == section; });
  return out;
}

/// The words that may stand at the top of a file.
std::set<std::string_view> sections() {
  std::set<std::string_view> out;
  for (const FlightKey& key : kKeys) {
    out.insert(key.section.empty() ? key.key : key.section);
  }
  return out;
}

/// Reads one table of the file; refuses a key without a row in kKeys.
void read_section(const TomlNode& table, const std::string& file, FlightFile& into) {
  const std::vector<FlightKey> keys = keys_of(table.name());
  const std::set<std::string_view> known = sections();
  for (const TomlNode& node : table.entries()) {
    if (table.name().empty() && !keys_of(node.key()).empty()) {
      read_section(node.table(), file, into);
    } else if (table.name().empty() && !known.contains(node.key())) {
      node.refuse("unknown key" + section_meant(node.key(), known));
    } else {
      const FlightKey& key = node.row_of(keys, &FlightKey::key);
      std::visit([&](auto member) { read(node, key, file, into.*member); }, key.member);
    }
  }
}

/// Refuses a key of the file, or its section where the file does not have it.
[[noreturn]] void refuse(const TomlNode& root, std::string_view section, std::string_view key,
                         const std::string& what) {
  const TomlNode* const table = root.get(section);
  const TomlNode* const node = table == nullptr ? nullptr : table->get(key);
  (node != nullptr    ? *node
   : table != nullptr ? *table
                      : root)
      .refuse(std::string(section) + "." + std::string(key), what);
}

void check_fence(const TomlNode& root, const FlightFile& flight) {
  const auto wrong = [&root](std::string_view key, const std::string& what) { refuse(root, "fence", key, what); };
  for (const auto& [key, box] : {std::pair{"x_m", flight.fence_x_m}, std::pair{"y_m", flight.fence_y_m}}) {
    if (!box.contains(0.0)) {
      wrong(key, "the start, 0, is not inside " + text_of(box));
    }
    if (box.low > -kRoom_m || box.high < kRoom_m) {
      wrong(key, text_of(box) + " leaves less than " + text_of(kRoom_m) +
                     " m on a side of the start: too narrow to hover in");
    }
  }
  if (flight.fence_z_m.high - flight.fence_z_m.low < 2.0 * kRoom_m) {
    wrong("z_m", text_of(flight.fence_z_m) + " is lower than " + text_of(2.0 * kRoom_m) + " m: too low to hover in");
  }
  if (flight.fence_z_m.low <= flight.ground_z_m) {
    wrong("z_m", "its floor is not above the ground at " + text_of(flight.ground_z_m) + " m ('fence.ground_z_m')");
  }
  if (flight.fence_z_m.high - flight.ground_z_m > kLegalHeight_m) {
    wrong("z_m", "reaches " + text_of(flight.fence_z_m.high - flight.ground_z_m) +
                     " m above the ground, and no drone may fly above " + text_of(kLegalHeight_m) +
                     " m; the fence is in metres, not in centimetres");
  }
}

void check_together(const TomlNode& root, const FlightFile& flight) {
  for (const FlightKey& key : kKeys) {
    const TomlNode* const section = root.get(key.section);
    if (key.required && (section == nullptr || section->get(key.key) == nullptr)) {
      refuse(root, key.section, key.key, "is missing: nothing flies without a fence");
    }
  }
  check_fence(root, flight);
  const safety::Limits limits = limits_of(flight);
  if (limits.coast <= limits.pose_fresh) {
    root.get("pose")->refuse("pose.coast_s", "must be longer than pose.fresh_s");
  }
  const auto most_m2 = link::PoseProperties::inside(fence_of(flight, {}), 0.0).max_variance_m2;
  const double largest_m = std::sqrt(*std::min_element(most_m2.begin(), most_m2.end()));
  if (flight.pose_sigma_m > largest_m) {
    refuse(root, "pose", "sigma_m",
           "at most " + text_of(largest_m) +
               " m can be flown inside this fence: three sigmas reach from its middle to a side");
  }
}

}  // namespace

std::string text_of(const Range& range) { return "[" + text_of(range.low) + ", " + text_of(range.high) + "]"; }

Mode mode_of(std::string_view word, const std::string& where) {
  if (const std::optional<Mode> mode = mode_named(present_mode_word(word))) {
    return *mode;
  }
  throw FileError(where + ": must be \"field\" or \"robust\"" +
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
    throw FileError(where + ": must be a sender's system, or system and component, as \"1\" or \"1:197\"");
  }
  return {.system = static_cast<std::uint8_t>(system), .component = static_cast<std::uint8_t>(component)};
}

std::span<const FlightKey> flight_keys() { return kKeys; }

FlightFile parse_flight(std::string_view text, const std::string& name) {
  const TomlNode root = parse_toml(text, name);
  FlightFile flight;
  read_section(root, name, flight);
  check_together(root, flight);
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
