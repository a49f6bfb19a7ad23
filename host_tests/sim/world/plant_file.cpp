// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/world/plant_file.h"

#include <algorithm>
#include <functional>
#include <map>
#include <set>
#include <span>
#include <sstream>
#include <type_traits>

#include "firmware/companion/files/text/regular_file.h"
#include "firmware/companion/files/text/suggestion.h"
#include "firmware/companion/files/text/toml_text.h"
#include "firmware/companion/files/vehicle_file.h"
#include "host_tests/sim/world/plant_keys.h"

namespace m100::sim {
namespace {

class Reader {
 public:
  Reader(const toml::table& root, const std::string& file) : root_(root), file_(file) {}

  /// The section's table, or null if the file has none.
  const toml::table* section(const std::string& name) {
    known_.insert(name);
    const toml::node_view<const toml::node> view = root_.at_path(name);
    if (!view) {
      return nullptr;
    }
    if (view.as_table() == nullptr) {
      fail(*view.node(), name, "must be a table");
    }
    return view.as_table();
  }

  template <typename T>
  void numbers(const std::string& name, std::span<const NumberKey<T>> keys, T& into) {
    if (const toml::table* const table = section(name)) {
      for (const auto& [key, node] : *table) {
        number(name, key.str(), node, keys, into);
      }
    }
  }

  void axis(const std::string& name, model::AxisUnit unit, model::StickAxis& into) {
    const std::span<const NumberKey<model::StickAxis>> keys = companion::axis_keys(unit);
    const toml::table* const table = section(name);
    if (table == nullptr) {
      return;
    }
    for (const auto& [key, node] : *table) {
      if (key == "dead_zone_shape") {
        into.dead_zone_shape = word<model::DeadZoneShape>(name + ".dead_zone_shape", node, kShapes);
      } else {
        number(name, key.str(), node, keys, into);
      }
    }
    settle_order(name, *table, into);
  }

  /// The keys of [pose], and their old names in [sensors].
  void pose(PoseNumbers& into) {
    const toml::table* const table = section("pose");
    if (table != nullptr) {
      for (const auto& [key, node] : *table) {
        if (key == "phase") {
          into.phase = word<PosePhase>("pose.phase", node, kPhases);
        } else if (key == "reported_age") {
          into.reported_age = word<ReportedAge>("pose.reported_age", node, kReportedAges);
        } else {
          number<PoseNumbers>("pose", key.str(), node, kPoseKeys, into);
        }
      }
    }
    if (const toml::table* const sensors = section("sensors"); sensors != nullptr) {
      old_pose_keys(*sensors, table, into);
    }
  }
  void old_pose_keys(const toml::table& sensors, const toml::table* pose, PoseNumbers& into) {
    for (const KeyAlias& name : kPoseKeyAliases) {
      const toml::node* const node = sensors.get(name.old);
      if (node == nullptr) {
        continue;
      }
      if (pose != nullptr && pose->contains(name.key)) {
        fail(*node, "sensors." + std::string(name.old), "is also given as pose." + std::string(name.key));
      }
      number<PoseNumbers>("pose", name.key, *node, kPoseKeys, into, "sensors." + std::string(name.old));
    }
  }

  void sensors(Sensors& into) {
    const toml::table* const table = section("sensors");
    if (table == nullptr) {
      return;
    }
    for (const auto& [key, node] : *table) {
      const std::string_view own = key.str();
      const auto is_old = [own](const KeyAlias& name) { return name.old == own; };
      if (std::none_of(kPoseKeyAliases.begin(), kPoseKeyAliases.end(), is_old)) {
        number<Sensors>("sensors", key.str(), node, kSensorKeys, into);
      }
    }
  }

  void wind(Air& air) {
    const toml::table* const table = section("air");
    if (table == nullptr) {
      return;
    }
    for (const auto& [key, node] : *table) {
      if (key != "wind_m_s") {
        number<Air>("air", key.str(), node, air_keys(), air);
        continue;
      }
      air.wind_m_s = three_numbers(node, "air.wind_m_s");
    }
  }

  /// [change]: its time, and any key of an axis or of the air by its full name, quoted or as nested tables.
  void change(Plant& plant) {
    const toml::table* const table = section("change");
    if (table == nullptr) {
      return;
    }
    read_change(*table, "", plant.change);
    if (!table->contains("at_s")) {
      fail(*table, "change.at_s", "is missing");
    }
    const Plant after = changed(plant);
    for (const auto& [name, axis] : kAxes) {
      expect_an_order(name, *table, after.*axis.member);
    }
  }

  void refuse_unknown() const {
    for (const auto& [key, node] : root_) {
      const std::string name(key.str());
      if (name == "axis" && !node.is_table()) {
        fail(node, name, "must be a table: [axis.roll] and so on");
      }
      if (name == "axis") {
        for (const auto& [axis, axis_node] : *node.as_table()) {
          if (!known_.contains("axis." + std::string(axis.str()))) {
            fail(axis_node, "axis." + std::string(axis.str()),
                 "unknown axis" + companion::did_you_mean("axis." + std::string(axis.str()), known_));
          }
        }
      } else if (!known_.contains(name)) {
        fail(node, name, "unknown section" + companion::section_meant(name, known_));
      }
    }
  }

 private:
  struct Axis {
    model::StickAxis Plant::*member;
    model::AxisUnit unit;
  };
  static inline const std::map<std::string, Axis> kAxes{
      {"axis.roll", {&Plant::roll, model::AxisUnit::kTilt_rad}},
      {"axis.pitch", {&Plant::pitch, model::AxisUnit::kTilt_rad}},
      {"axis.yaw_rate", {&Plant::yaw_rate, model::AxisUnit::kYawRate_rad_s}},
      {"axis.climb", {&Plant::climb, model::AxisUnit::kClimb_m_s}}};

  void read_change(const toml::table& table, const std::string& prefix, Change& into) const {
    for (const auto& [key, node] : table) {
      const std::string name = prefix + std::string(key.str());
      if (node.is_table()) {
        read_change(*node.as_table(), name + ".", into);
      } else if (name == "at_s") {
        into.at_s = in_range(node, "change.at_s", 0.0, 1e6);
      } else {
        into.steps.push_back(step_of(name, node));
      }
    }
  }

  /// The change that one line of [change] makes. The number is checked now, on a separate plant.
  std::function<void(Plant&)> step_of(const std::string& name, const toml::node& node) const {
    const std::size_t dot = name.rfind('.');
    const std::string where = dot == std::string::npos ? "" : name.substr(0, dot);
    const std::string key = name.substr(dot + 1);
    if (name == "air.wind_m_s") {
      return [wind = three_numbers(node, "change." + name)](Plant& plant) { plant.air.wind_m_s = wind; };
    }
    if (where == "air") {
      for (const NumberKey<Air>& known : air_keys()) {
        if (known.key == key) {
          const double value = in_range(node, "change." + name, known.low, known.high);
          return [member = known.member, value](Plant& plant) { plant.air.*member = value; };
        }
      }
    }
    const auto axis = kAxes.find(where);
    if (axis == kAxes.end()) {
      fail(node, "change." + name,
           "is not a key of an axis or of the air" +
               (where == "air" ? companion::did_you_mean(key, air_keys(), &NumberKey<Air>::key)
                               : companion::did_you_mean(where, kAxes, &std::pair<const std::string, Axis>::first)));
    }
    const auto member = axis->second.member;
    if (key == "dead_zone_shape") {
      return [member, shape = word<model::DeadZoneShape>("change." + name, node, kShapes)](Plant& plant) {
        (plant.*member).dead_zone_shape = shape;
      };
    }
    model::StickAxis probe;
    number<model::StickAxis>(where, key, node, companion::axis_keys(axis->second.unit), probe);
    double model::StickAxis::*const changes = member_of(key, axis->second.unit);
    return [member, changes, value = probe.*changes](Plant& plant) {
      model::StickAxis& axis_now = plant.*member;
      axis_now.*changes = value;
      if (changes == &model::StickAxis::time_constant_s && value > 0.0) {
        axis_now.natural_frequency_rad_s = 0.0;
      } else if (changes == &model::StickAxis::natural_frequency_rad_s && value > 0.0) {
        axis_now.time_constant_s = 0.0;
        damp_what_was_first_order(axis_now, false);
      }
    };
  }

  static double model::StickAxis::*member_of(std::string_view key, model::AxisUnit unit) {
    for (const NumberKey<model::StickAxis>& known : companion::axis_keys(unit)) {
      if (known.key == key) {
        return known.member;
      }
    }
    return nullptr;  // number() reports the error
  }

  core::Vector<double, 3> three_numbers(const toml::node& node, const std::string& key) const {
    const toml::array* const entries = node.as_array();
    if (entries == nullptr || entries->size() != 3) {
      fail(node, key, "must be three numbers [x, y, z]");
    }
    core::Vector<double, 3> out;
    for (std::size_t i = 0; i < 3; ++i) {
      out[static_cast<Eigen::Index>(i)] = in_range(*entries->get(i), key, -40.0, 40.0);
    }
    return out;
  }

  /// A key of an axis in its own section, or by its full name in another section, quoted or as nested tables.
  static const toml::node* node_of(const toml::table& table, const std::string& axis, const std::string& key) {
    if (const toml::node* const own = table.get(key); own != nullptr) {
      return own;
    }
    const std::string full = axis + "." + key;
    const toml::node* const quoted = table.get(full);
    return quoted != nullptr ? quoted : table.at_path(full).node();
  }

  /// Requires that the axis has dynamics. The error names the key that removes them. @param table the axis's section,
  /// or [change] with the axis's keys by their full names.
  void expect_an_order(const std::string& name, const toml::table& table, const model::StickAxis& axis) const {
    const auto refuse = [&](const std::string& key, const std::string& what, bool even_if_absent) {
      const toml::node* const node = node_of(table, name, key);
      if (node != nullptr ? node->value<double>().has_value() : even_if_absent) {
        fail(node != nullptr ? *node : static_cast<const toml::node&>(table), name + "." + key, what);
      }
    };
    if (!axis.is_identified()) {
      refuse("natural_frequency_rad_s", "0 leaves the axis without dynamics: give time_constant_s instead", false);
      refuse("time_constant_s", "0 leaves the axis without dynamics: give natural_frequency_rad_s instead", true);
    }
    if (axis.natural_frequency_rad_s > 0.0 && !(axis.damping_ratio > 0.0)) {
      refuse("damping_ratio", "must be above 0 together with natural_frequency_rad_s", true);
    }
    if (axis.natural_frequency_rad_s == 0.0 && axis.damping_ratio != 0.0) {
      refuse("damping_ratio", "has no effect on a first order: give natural_frequency_rad_s too", false);
    }
  }

  /// A second order that replaces a measured first order has no measured damping: 1 is used, which does not overshoot.
  static void damp_what_was_first_order(model::StickAxis& axis, bool is_given) {
    if (!is_given && axis.damping_ratio == 0.0) {
      axis.damping_ratio = 1.0;
    }
  }

  /// A time constant replaces an axis's second order, a natural frequency its first order.
  void settle_order(const std::string& name, const toml::table& table, model::StickAxis& into) const {
    const auto given = [&table](const char* key) { return table[key].value<double>().value_or(0.0) != 0.0; };
    const bool first = given("time_constant_s");
    const bool second = given("natural_frequency_rad_s");
    if (first && second) {
      fail(table, name, "give either time_constant_s or natural_frequency_rad_s with damping_ratio");
    }
    if (first) {
      into.natural_frequency_rad_s = 0.0;
      into.damping_ratio = given("damping_ratio") ? into.damping_ratio : 0.0;
    } else if (second) {
      into.time_constant_s = 0.0;
      damp_what_was_first_order(into, table.contains("damping_ratio"));
    }
    expect_an_order(name, table, into);
  }

  template <typename T, typename Words>
  T word(const std::string& key, const toml::node& node, const Words& words) const {
    const std::string said = node.value<std::string>().value_or("");
    std::string known;
    for (const NamedValue<T>& one : words) {
      if (one.word == said) {
        return one.value;
      }
      known += (known.empty() ? "\"" : " or \"") + std::string(one.word) + "\"";
    }
    fail(node, key, "must be " + known + companion::did_you_mean(said, words, &NamedValue<T>::word));
  }

  [[noreturn]] void fail(const toml::node& node, const std::string& key, const std::string& what) const {
    throw PlantFileError(file_ + ":" + std::to_string(node.source().begin.line) + ": '" + key + "': " + what);
  }

  template <typename T>
  void number(const std::string& section, std::string_view key, const toml::node& node,
              std::span<const NumberKey<T>> keys, T& into, const std::string& as_written = "") const {
    const std::string full = as_written.empty() ? section + "." + std::string(key) : as_written;
    if (key == "source" && node.is_string()) {
      return;
    }
    for (const NumberKey<T>& known : keys) {
      if (known.key == key) {
        const double value = in_range(node, full, known.low, known.high);
        // Zero switches an effect off, also one whose neutral value is another number, such as a gain of 1.
        into.*known.member = value == 0.0 ? off(known, into) : value;
        return;
      }
    }
    fail(node, full, "unknown key" + companion::did_you_mean(key, keys, &NumberKey<T>::key));
  }

  template <typename T>
  static double off(const NumberKey<T>& key, const T&) {
    return std::is_same_v<T, model::StickAxis> ? T{}.*key.member : 0.0;
  }

  double in_range(const toml::node& node, const std::string& key, double low, double high) const {
    if (!node.is_number()) {
      fail(node, key, "must be a number");
    }
    const double value = *node.value<double>();
    const bool absent = value == 0.0 && key.starts_with("axis.") && key.find("scale") == std::string::npos;
    if (!absent && !(value >= low && value <= high)) {
      std::ostringstream text;
      text << value << " is outside [" << low << ", " << high << "]";
      fail(node, key, text.str());
    }
    return value;
  }

  const toml::table& root_;
  const std::string& file_;
  std::set<std::string> known_;
};

}  // namespace

Plant parse_plant(std::string_view text, const std::string& name, const Plant& base) {
  toml::table root;
  try {
    root = companion::parse_toml(text);
  } catch (const companion::TomlTextError& wrong) {
    throw PlantFileError(name + ":" + std::to_string(wrong.line) + ": " + wrong.what());
  }
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) {
    throw PlantFileError(name + ": the file is empty; a file with only a comment selects the base plant");
  }
  Plant plant = base;
  Reader reader(root, name);
  reader.axis("axis.roll", model::AxisUnit::kTilt_rad, plant.roll);
  reader.axis("axis.pitch", model::AxisUnit::kTilt_rad, plant.pitch);
  reader.axis("axis.yaw_rate", model::AxisUnit::kYawRate_rad_s, plant.yaw_rate);
  reader.axis("axis.climb", model::AxisUnit::kClimb_m_s, plant.climb);
  reader.wind(plant.air);
  reader.numbers<Payload>("payload", kPayloadKeys, plant.payload);
  reader.pose(plant.pose);
  reader.sensors(plant.sensors);
  reader.numbers<Link>("link", kLinkKeys, plant.link);
  reader.numbers<Battery>("battery", kBatteryKeys, plant.battery);
  reader.numbers<AutopilotNumbers>("autopilot", kAutopilotKeys, plant.autopilot);
  reader.numbers<Plant>("vehicle", kVehicleKeys, plant);
  reader.change(plant);
  reader.refuse_unknown();
  return plant;
}

Plant load_plant(const std::string& path, const Plant& base) {
  const companion::FileContent content = companion::read_regular(path, companion::kMaxTextBytes);
  if (!content.why_not.empty()) {
    throw PlantFileError(path + ": " + content.why_not);
  }
  return parse_plant(content.bytes, path, base);
}

}  // namespace m100::sim
