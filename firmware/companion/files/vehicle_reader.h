// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <charconv>
#include <limits>
#include <set>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include "firmware/companion/files/text/suggestion.h"
#include "firmware/companion/files/text/toml_text.h"
#include "firmware/companion/files/vehicle_file.h"
#include "firmware/companion/files/vehicle_keys.h"

// Only vehicle_file.cpp includes this file.
namespace m100::companion {

/// The shortest text that reads back to the same bits.
inline std::string shortest_number(double value) {
  std::array<char, 32> buffer{};
  const std::to_chars_result end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  std::string text(buffer.data(), end.ptr);
  return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;  // TOML: a float needs a point
}

[[noreturn]] inline void vehicle_file_fail(const std::string& file, const toml::node* node, const std::string& key,
                                           const std::string& what) {
  const auto line = node == nullptr ? 0U : node->source().begin.line;
  throw VehicleFileError(file + (line > 0 ? ":" + std::to_string(line) : "") + ": '" + key + "': " + what);
}

inline constexpr std::string_view kDeadZoneShapeKey = "dead_zone_shape";
inline constexpr std::string_view kDesignKey = "design";

/// Whether altitude.design = true replaces this height gain, so that the file's own number has no effect.
inline bool is_designed(double model::AltitudeGains::*member) {
  using Gains = model::AltitudeGains;
  return member == &Gains::proportional_per_s || member == &Gains::integral_per_s2 || member == &Gains::derivative;
}

/// Reads the sections of one file into one struct.
class VehicleReader {
 public:
  VehicleReader(const toml::table& root, const std::string& file, VehicleFile& out)
      : root_(root), file_(file), out_(out) {}

  template <typename T>
  void section(const std::string& name, std::span<const NumberKey<T>> keys, T& into) {
    const toml::node_view<const toml::node> view = root_.at_path(name);
    known_.insert(name);
    if (!view) {
      return;
    }
    const toml::table* table = view.as_table();
    if (table == nullptr) {
      vehicle_file_fail(file_, view.node(), name, "must be a table");
    }
    out_.sections.insert(name);
    for (const auto& [key, node] : *table) {
      read_key(name, std::string(key.str()), node, keys, into);
    }
    check_order(name, *table, keys, into);
    refuse_designed_gains(name, *table, keys, into);
    if (out_.intervals.contains(name)) {
      check_intervals(name, *table, out_.intervals.at(name));
    }
  }

  /// A section whose absence means something. @param exists receives whether the file has it
  template <typename T>
  void optional_section(const std::string& name, std::span<const NumberKey<T>> keys, T& into, bool& exists) {
    section(name, keys, into);
    exists = out_.sections.contains(name);
  }

  /// [[rival]]: axis, the keys of an axis with their intervals, probability, source.
  void rivals() {
    known_.insert("rival");
    const toml::node* node = root_.get("rival");
    if (node == nullptr) {
      return;
    }
    if (!node->is_array_of_tables()) {
      vehicle_file_fail(file_, node, "rival", "must be written [[rival]]");
    }
    for (const toml::node& one : *node->as_array()) {
      out_.rivals.push_back(rival(*one.as_table()));
    }
  }

  /// Refuses the first unknown section.
  void refuse_unknown() const { refuse_unknown_in(root_, ""); }

 private:
  /// Recurses into sections that hold sections: at most three levels.
  void refuse_unknown_in(const toml::table& table, const std::string& before) const {
    for (const auto& [key, node] : table) {
      const std::string name = before + std::string(key.str());
      if (name == "axis" || name == "design" || name == "design.robust") {
        if (node.as_table() == nullptr) {
          vehicle_file_fail(file_, &node, name, "must be a table");
        }
        refuse_unknown_in(*node.as_table(), name + ".");
      } else if (!known_.contains(name)) {
        vehicle_file_fail(file_, &node, name,
                          before == "axis." ? "unknown axis" + did_you_mean(name, known_)
                                            : "unknown section" + section_meant(name, known_));
      }
    }
  }

  Rival rival(const toml::table& table) {
    const std::string name = "rival";
    const std::span<const NumberKey<model::StickAxis>> keys = axis_keys(model::AxisUnit::kTilt_rad);
    Rival out;
    for (const auto& [key, node] : table) {
      if (key.str() == "axis") {
        out.axis = node.value<std::string>().value_or("");
      } else if (key.str() == "probability") {
        out.probability = number(node, "rival.probability", 0.0, 1.0, false);
      } else {
        read_key(name, std::string(key.str()), node, keys, out.numbers);
      }
    }
    if (out.axis != "roll" && out.axis != "pitch") {
      const toml::node* axis = table.get("axis");
      vehicle_file_fail(file_, axis == nullptr ? &table : axis, "rival.axis", "must be \"roll\" or \"pitch\"");
    }
    check_order(name, table, keys, out.numbers);
    if (out_.intervals.contains(name)) {
      check_intervals(name, table, out_.intervals.at(name));
      out.intervals = std::move(out_.intervals.extract(name).mapped());
    }
    if (out_.sources.contains(name)) {
      out.source = std::move(out_.sources.extract(name).mapped());
    }
    return out;
  }

  /// @returns whether the key is KEY_low or KEY_high of a key of this section; then it has been read
  template <typename T>
  bool read_interval(const std::string& section, const std::string& key, const toml::node& node,
                     std::span<const NumberKey<T>> keys) {
    const bool is_low = key.ends_with("_low");
    if ((!is_low && !key.ends_with("_high")) || section.starts_with("design")) {
      return false;
    }
    const std::string stem = key.substr(0, key.rfind('_'));
    for (const NumberKey<T>& known : keys) {
      if (known.key == stem) {
        if (!node.is_number()) {
          vehicle_file_fail(file_, &node, section + "." + key, "must be a number");
        }
        const auto at = out_.intervals[section].try_emplace(stem, Interval{kUnknown, kUnknown}).first;
        (is_low ? at->second.low : at->second.high) = *node.value<double>();
        return true;
      }
    }
    return false;
  }

  void check_intervals(const std::string& section, const toml::table& table, const Intervals& intervals) const {
    for (const auto& [key, interval] : intervals) {
      const bool has_low = interval.low == interval.low;
      const std::string full = section + "." + key;
      if (!has_low || interval.high != interval.high) {
        vehicle_file_fail(file_, &table, full + (has_low ? "_high" : "_low"), "missing: an interval has both ends");
      }
      if (interval.low > interval.high) {
        vehicle_file_fail(file_, table.get(key + "_low"), full + "_low", "must not be above " + full + "_high");
      }
    }
  }

  template <typename T>
  void read_key(const std::string& section, const std::string& key, const toml::node& node,
                std::span<const NumberKey<T>> keys, T& into) {
    const std::string full = section + "." + key;
    if (key == "source") {
      if (!node.is_string()) {
        vehicle_file_fail(file_, &node, full, "must be a text");
      }
      out_.sources[section] = *node.value<std::string>();
      return;
    }
    if constexpr (requires { into.dead_zone_shape; }) {
      if (key == kDeadZoneShapeKey) {
        into.dead_zone_shape = shape(node, full);
        return;
      }
    }
    if constexpr (requires { into.design; }) {
      if (key == kDesignKey) {
        if (!node.is_boolean()) {
          vehicle_file_fail(file_, &node, full, "must be true or false");
        }
        into.design = *node.value<bool>();
        return;
      }
    }
    for (const NumberKey<T>& known : keys) {
      if (known.key == key) {
        const bool may_be_absent = T{}.*known.member == 0.0;
        into.*known.member = number(node, full, known.low, known.high, may_be_absent);
        return;
      }
    }
    if constexpr (std::is_same_v<T, model::StickAxis>) {
      if (read_interval(section, key, node, keys)) {
        return;
      }
    }
    vehicle_file_fail(file_, &node, full, "unknown key" + did_you_mean(key, keys, &NumberKey<T>::key));
  }

  model::DeadZoneShape shape(const toml::node& node, const std::string& full) const {
    const std::string word = node.value<std::string>().value_or("");
    if (word != "continuous" && word != "jump") {
      vehicle_file_fail(file_, &node, full, "must be \"continuous\" or \"jump\"");
    }
    return word == "jump" ? model::DeadZoneShape::kJump : model::DeadZoneShape::kContinuous;
  }

  double number(const toml::node& node, const std::string& full, double low, double high, bool may_be_absent) const {
    if (!node.is_number()) {
      vehicle_file_fail(file_, &node, full, "must be a number");
    }
    const double value = *node.value<double>();
    // Zero means "no such effect" in keys whose default is 0, although their range begins above it.
    const bool absent = value == 0.0 && may_be_absent && full.find("scale") == std::string::npos;
    if (!absent && !(value >= low && value <= high)) {
      vehicle_file_fail(
          file_, &node, full,
          shortest_number(value) + " is outside [" + shortest_number(low) + ", " + shortest_number(high) + "]");
    }
    return value;
  }

  /// An axis is of first order (time constant) or of second order (frequency and damping), never both or neither.
  template <typename T>
  void check_order(const std::string& name, const toml::table& table, std::span<const NumberKey<T>> keys,
                   const T& axis) const {
    if constexpr (std::is_same_v<T, model::StickAxis>) {
      const bool first = axis.time_constant_s > 0.0;
      const bool second = axis.natural_frequency_rad_s > 0.0;
      if (first && second) {
        vehicle_file_fail(file_, table.get("time_constant_s"), name + ".time_constant_s",
                          "an axis has a time constant or a natural frequency, not both");
      }
      if (!first && !second) {
        vehicle_file_fail(file_, &table, name + ".time_constant_s",
                          "missing: give it, or natural_frequency_rad_s and damping_ratio");
      }
      if (second && !(axis.damping_ratio > 0.0)) {
        vehicle_file_fail(file_, &table, name + ".damping_ratio", "missing beside natural_frequency_rad_s");
      }
      if (!table.contains(keys.front().key)) {
        vehicle_file_fail(file_, &table, name, "its scale per count is missing");
      }
    }
  }

  /// A height gain that altitude.design = true replaces is an error, unless it has its default value.
  template <typename T>
  void refuse_designed_gains(const std::string& name, const toml::table& table, std::span<const NumberKey<T>> keys,
                             const T& gains) const {
    if constexpr (std::is_same_v<T, model::AltitudeGains>) {
      for (const NumberKey<T>& key : keys) {
        if (gains.design && is_designed(key.member) && gains.*key.member != T{}.*key.member) {
          vehicle_file_fail(file_, table.get(key.key), name + "." + std::string(key.key),
                            "has no effect without design = false");
        }
      }
    }
  }

  const toml::table& root_;
  const std::string& file_;
  VehicleFile& out_;
  std::set<std::string> known_;
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace m100::companion
