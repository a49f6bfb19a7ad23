// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/world/plant_file.h"

#include <algorithm>
#include <functional>
#include <map>
#include <set>
#include <span>
#include <type_traits>

#include "firmware/companion/files/text/regular_file.h"
#include "firmware/companion/files/text/toml_text.h"
#include "firmware/companion/files/vehicle_file.h"
#include "host_tests/sim/world/plant_keys.h"

namespace m100::sim {
namespace {

using companion::TomlNode;
using AxisKeys = std::span<const NumberKey<model::StickAxis>>;

class Reader {
 public:
  explicit Reader(const TomlNode& root) : root_(root) {}

  /// The section's table, or null if the file has none.
  const TomlNode* section(const std::string& name) {
    known_.insert(name);
    const std::size_t dot = name.find('.');
    const TomlNode* node = root_.get(name.substr(0, dot));
    if (node != nullptr && dot != std::string::npos) {
      node = node->table().get(name.substr(dot + 1));
    }
    return node == nullptr ? nullptr : &node->table();
  }

  template <typename T>
  void numbers(const std::string& name, std::span<const NumberKey<T>> keys, T& into) {
    if (const TomlNode* const table = section(name)) {
      for (const TomlNode& node : table->entries()) {
        number(node, keys, into);
      }
    }
  }

  void axis(const std::string& name, model::AxisUnit unit, model::StickAxis& into) {
    const TomlNode* const table = section(name);
    if (table == nullptr) {
      return;
    }
    for (const TomlNode& node : table->entries()) {
      if (node.key() == "dead_zone_shape") {
        into.dead_zone_shape = node.word_of(companion::kDeadZoneShapes).value;
      } else {
        number(node, companion::axis_keys(unit), into);
      }
    }
    settle_order(name, *table, into);
  }

  /// The keys of [pose], and their old names in [sensors].
  void pose(PoseNumbers& into) {
    const TomlNode* const table = section("pose");
    if (table != nullptr) {
      for (const TomlNode& node : table->entries()) {
        if (node.key() == "phase") {
          into.phase = node.word_of(kPhases).value;
        } else if (node.key() == "reported_age") {
          into.reported_age = node.word_of(kReportedAges).value;
        } else {
          number<PoseNumbers>(node, kPoseKeys, into);
        }
      }
    }
    if (const TomlNode* const sensors = section("sensors"); sensors != nullptr) {
      old_pose_keys(*sensors, table, into);
    }
  }
  static void old_pose_keys(const TomlNode& sensors, const TomlNode* pose, PoseNumbers& into) {
    for (const KeyAlias& name : kPoseKeyAliases) {
      const TomlNode* const node = sensors.get(name.old);
      if (node == nullptr) {
        continue;
      }
      if (pose != nullptr && pose->get(name.key) != nullptr) {
        node->refuse("is also given as pose." + std::string(name.key));
      }
      const auto key =
          std::find_if(kPoseKeys.begin(), kPoseKeys.end(), [&](const auto& one) { return one.key == name.key; });
      take(*node, *key, into);
    }
  }

  void sensors(Sensors& into) {
    const TomlNode* const table = section("sensors");
    if (table == nullptr) {
      return;
    }
    for (const TomlNode& node : table->entries()) {
      const auto is_old = [&node](const KeyAlias& name) { return name.old == node.key(); };
      if (std::none_of(kPoseKeyAliases.begin(), kPoseKeyAliases.end(), is_old)) {
        number<Sensors>(node, kSensorKeys, into);
      }
    }
  }

  void wind(Air& air) {
    const TomlNode* const table = section("air");
    if (table == nullptr) {
      return;
    }
    for (const TomlNode& node : table->entries()) {
      if (node.key() == "wind_m_s") {
        air.wind_m_s = three_numbers(node);
      } else {
        number<Air>(node, air_keys(), air);
      }
    }
  }

  /// [change]: its time, and any key of an axis or of the air by its full name, quoted or as nested tables.
  void change(Plant& plant) {
    const TomlNode* const table = section("change");
    if (table == nullptr) {
      return;
    }
    read_change(*table, plant.change);
    if (table->get("at_s") == nullptr) {
      table->refuse_without("at_s", "is missing");
    }
    const Plant after = changed(plant);
    for (const auto& [name, axis] : kAxes) {
      expect_an_order(name, *table, after.*axis.member);
    }
  }

  void refuse_unknown() const {
    for (const TomlNode& node : root_.entries()) {
      if (node.key() == "axis") {
        for (const TomlNode& axis : node.table().entries()) {
          if (!known_.contains(axis.name())) {
            axis.refuse("unknown axis" + companion::did_you_mean(axis.name(), known_));
          }
        }
      } else if (!known_.contains(node.key())) {
        node.refuse("unknown section" + companion::section_meant(node.key(), known_));
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

  void read_change(const TomlNode& table, Change& into) const {
    for (const TomlNode& node : table.entries()) {
      if (node.is_table()) {
        read_change(node, into);
      } else if (node.name() == "change.at_s") {
        into.at_s = node.number(0.0, 1e6);
      } else {
        into.steps.push_back(step_of(node));
      }
    }
  }

  /// The change that one line of [change] makes. The number is checked now, on a separate plant.
  static std::function<void(Plant&)> step_of(const TomlNode& node) {
    const std::string name = node.name().substr(std::string_view("change.").size());
    const std::size_t dot = name.rfind('.');
    const std::string where = dot == std::string::npos ? "" : name.substr(0, dot);
    const std::string key = name.substr(dot + 1);
    const auto has_key = [&key](const auto& known) { return known.key == key; };
    if (name == "air.wind_m_s") {
      return [wind = three_numbers(node)](Plant& plant) { plant.air.wind_m_s = wind; };
    }
    const auto air = std::find_if(air_keys().begin(), air_keys().end(), has_key);
    if (where == "air" && air != air_keys().end()) {
      const double value = node.number(air->low, air->high);
      return [member = air->member, value](Plant& plant) { plant.air.*member = value; };
    }
    const auto axis = kAxes.find(where);
    if (axis == kAxes.end()) {
      node.refuse("is not a key of an axis or of the air" +
                  (where == "air" ? companion::did_you_mean(key, air_keys(), &NumberKey<Air>::key)
                                  : companion::did_you_mean(where, kAxes, &std::pair<const std::string, Axis>::first)));
    }
    const auto member = axis->second.member;
    if (key == "dead_zone_shape") {
      return [member, shape = node.word_of(companion::kDeadZoneShapes).value](Plant& plant) {
        (plant.*member).dead_zone_shape = shape;
      };
    }
    const AxisKeys keys = companion::axis_keys(axis->second.unit);
    const auto known = std::find_if(keys.begin(), keys.end(), has_key);
    if (known == keys.end()) {
      node.refuse("unknown key" + companion::did_you_mean(key, keys, &NumberKey<model::StickAxis>::key));
    }
    model::StickAxis probe;
    take(node, *known, probe);
    return [member, changes = known->member, value = probe.*known->member](Plant& plant) {
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

  static core::Vector<double, 3> three_numbers(const TomlNode& node) {
    if (!node.is_array() || node.entries().size() != 3) {
      node.refuse("must be three numbers [x, y, z]");
    }
    core::Vector<double, 3> out;
    std::transform(node.entries().begin(), node.entries().end(), out.begin(),
                   [](const TomlNode& one) { return one.number(-40.0, 40.0); });
    return out;
  }

  /// The entry with that full name, quoted or in nested tables; null: there is none. Recurses as deep as tables are
  /// nested: at most companion::kMaxTomlDepth.
  static const TomlNode* named(const TomlNode& table, const std::string& name) {
    for (const TomlNode& node : table.entries()) {
      if (const TomlNode* const found = node.name() == name ? &node : named(node, name); found != nullptr) {
        return found;
      }
    }
    return nullptr;
  }

  /// Requires that the axis has dynamics. The error names the key that removes them. @param table the axis's section,
  /// or [change] with the axis's keys by their full names.
  static void expect_an_order(const std::string& name, const TomlNode& table, const model::StickAxis& axis) {
    const auto refuse = [&](const std::string& key, const std::string& what, bool even_if_absent) {
      const TomlNode* const node = named(table, (table.name() == name ? "" : table.name() + ".") + name + "." + key);
      if (node != nullptr || even_if_absent) {
        (node != nullptr ? *node : table).refuse(name + "." + key, what);
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
  static void settle_order(const std::string& name, const TomlNode& table, model::StickAxis& into) {
    const auto given = [&table](const char* key) {
      return table.get(key) != nullptr && table.get(key)->number() != 0.0;
    };
    const bool first = given("time_constant_s");
    const bool second = given("natural_frequency_rad_s");
    if (first && second) {
      table.refuse("give either time_constant_s or natural_frequency_rad_s with damping_ratio");
    }
    if (first) {
      into.natural_frequency_rad_s = 0.0;
      into.damping_ratio = given("damping_ratio") ? into.damping_ratio : 0.0;
    } else if (second) {
      into.time_constant_s = 0.0;
      damp_what_was_first_order(into, table.get("damping_ratio") != nullptr);
    }
    expect_an_order(name, table, into);
  }

  template <typename T>
  static void number(const TomlNode& node, std::span<const NumberKey<T>> keys, T& into) {
    if (node.key() != "source" || !node.is(TomlNode::Kind::kText)) {
      take(node, node.row_of(keys, &NumberKey<T>::key), into);
    }
  }

  /// Zero switches an effect of an axis off, also one whose range begins above it or whose neutral value is another
  /// number, such as a gain of 1.
  template <typename T>
  static void take(const TomlNode& node, const NumberKey<T>& key, T& into) {
    const bool is_off = std::is_same_v<T, model::StickAxis> && !key.key.starts_with("scale") && node.number() == 0.0;
    into.*key.member = is_off ? T{}.*key.member : node.number(key.low, key.high);
  }

  const TomlNode& root_;
  std::set<std::string> known_;
};

}  // namespace

Plant parse_plant(std::string_view text, const std::string& name, const Plant& base) {
  const TomlNode root = companion::parse_toml(text, name);
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) {
    throw companion::FileError(name + ": the file is empty; a file with only a comment selects the base plant");
  }
  Plant plant = base;
  Reader reader(root);
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
    throw companion::FileError(path + ": " + content.why_not);
  }
  return parse_plant(content.bytes, path, base);
}

}  // namespace m100::sim
