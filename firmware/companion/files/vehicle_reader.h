// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <functional>
#include <iterator>
#include <limits>
#include <set>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

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
  VehicleReader(const TomlNode& root, VehicleFile& out) : root_(root), out_(out) {}

  template <typename T>
  void section(const std::string& name, std::span<const NumberKey<T>> keys, T& into) {
    known_.insert(name);
    const TomlNode* table = &root_;
    for (std::size_t at = 0, end = 0; table != nullptr && end != std::string::npos; at = end + 1) {
      end = name.find('.', at);
      table = table->get(std::string_view(name).substr(at, end - at));
    }
    if (table == nullptr) {
      return;
    }
    out_.sections.insert(name);
    for (const TomlNode& node : table->table().entries()) {
      read_key(name, node, keys, into);
    }
    check_order(*table, keys, into);
    refuse_designed_gains(*table, keys, into);
    if (out_.intervals.contains(name)) {
      check_intervals(*table, out_.intervals.at(name));
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
    const TomlNode* node = root_.get("rival");
    if (node == nullptr) {
      return;
    }
    const std::vector<TomlNode>& all = node->entries();
    if (!node->is_array() || all.empty() || !std::all_of(all.begin(), all.end(), std::mem_fn(&TomlNode::is_table))) {
      node->refuse("must be written [[rival]]");
    }
    std::transform(all.begin(), all.end(), std::back_inserter(out_.rivals),
                   [this](const auto& one) { return rival(one); });
  }

  /// Refuses the first unknown section.
  void refuse_unknown() const { refuse_unknown_in(root_); }

 private:
  /// Recurses into sections that hold sections: at most three levels.
  void refuse_unknown_in(const TomlNode& table) const {
    for (const TomlNode& node : table.entries()) {
      const std::string& name = node.name();
      if (name == "axis" || name == "design" || name == "design.robust") {
        refuse_unknown_in(node.table());
      } else if (!known_.contains(name)) {
        node.refuse(table.name() == "axis" ? "unknown axis" + did_you_mean(name, known_)
                                           : "unknown section" + section_meant(name, known_));
      }
    }
  }

  Rival rival(const TomlNode& table) {
    const std::string name = "rival";
    const std::span<const NumberKey<model::StickAxis>> keys = axis_keys(model::AxisUnit::kTilt_rad);
    Rival out;
    for (const TomlNode& node : table.entries()) {
      if (node.key() == "axis") {
        out.axis = node.text();
      } else if (node.key() == "probability") {
        out.probability = node.number(0.0, 1.0);
      } else {
        read_key(name, node, keys, out.numbers);
      }
    }
    if (out.axis != "roll" && out.axis != "pitch") {
      const TomlNode* axis = table.get("axis");
      (axis == nullptr ? table : *axis).refuse("rival.axis", "must be \"roll\" or \"pitch\"");
    }
    check_order(table, keys, out.numbers);
    if (out_.intervals.contains(name)) {
      check_intervals(table, out_.intervals.at(name));
      out.intervals = std::move(out_.intervals.extract(name).mapped());
    }
    if (out_.sources.contains(name)) {
      out.source = std::move(out_.sources.extract(name).mapped());
    }
    return out;
  }

  /// @returns whether the key is KEY_low or KEY_high of a key of this section; then it has been read
  template <typename T>
  bool read_interval(const std::string& section, const TomlNode& node, std::span<const NumberKey<T>> keys) {
    const std::string& key = node.key();
    const bool is_low = key.ends_with("_low");
    if ((!is_low && !key.ends_with("_high")) || section.starts_with("design")) {
      return false;
    }
    const std::string stem = key.substr(0, key.rfind('_'));
    if (std::none_of(keys.begin(), keys.end(), [&](const NumberKey<T>& known) { return known.key == stem; })) {
      return false;
    }
    const auto at = out_.intervals[section].try_emplace(stem, Interval{kUnknown, kUnknown}).first;
    (is_low ? at->second.low : at->second.high) = node.number();
    return true;
  }

  static void check_intervals(const TomlNode& table, const Intervals& intervals) {
    for (const auto& [key, interval] : intervals) {
      const bool has_low = interval.low == interval.low;
      if (!has_low || interval.high != interval.high) {
        table.refuse_without(key + (has_low ? "_high" : "_low"), "missing: an interval has both ends");
      }
      if (interval.low > interval.high) {
        table.get(key + "_low")->refuse("must not be above " + table.name() + "." + key + "_high");
      }
    }
  }

  template <typename T>
  void read_key(const std::string& section, const TomlNode& node, std::span<const NumberKey<T>> keys, T& into) {
    const std::string& key = node.key();
    if (key == "source") {
      if (!node.is(TomlNode::Kind::kText)) {
        node.refuse("must be a text");
      }
      out_.sources[section] = node.text();
      return;
    }
    if constexpr (requires { into.design; }) {
      if (key == kDesignKey) {
        into.design = node.flag();
        return;
      }
    }
    if constexpr (std::is_same_v<T, model::StickAxis>) {
      if (key == kDeadZoneShapeKey) {
        into.dead_zone_shape = node.word_of(kDeadZoneShapes).value;
        return;
      }
      if (read_interval(section, node, keys)) {
        return;
      }
    }
    const NumberKey<T>& known = node.row_of(keys, &NumberKey<T>::key);
    // Zero means "no such effect" in keys whose default is 0, although their range begins above it.
    const bool may_be_absent = T{}.*known.member == 0.0 && !key.starts_with("scale");
    into.*known.member = may_be_absent && node.number() == 0.0 ? 0.0 : node.number(known.low, known.high);
  }

  /// An axis is of first order (time constant) or of second order (frequency and damping), never both or neither.
  template <typename T>
  static void check_order(const TomlNode& table, std::span<const NumberKey<T>> keys, const T& axis) {
    if constexpr (std::is_same_v<T, model::StickAxis>) {
      const bool first = axis.time_constant_s > 0.0;
      const bool second = axis.natural_frequency_rad_s > 0.0;
      if (first && second) {
        table.get("time_constant_s")->refuse("an axis has a time constant or a natural frequency, not both");
      }
      if (!first && !second) {
        table.refuse_without("time_constant_s", "missing: give it, or natural_frequency_rad_s and damping_ratio");
      }
      if (second && !(axis.damping_ratio > 0.0)) {
        table.refuse_without("damping_ratio", "missing beside natural_frequency_rad_s");
      }
      if (table.get(keys.front().key) == nullptr) {
        table.refuse("its scale per count is missing");
      }
    }
  }

  /// A height gain that altitude.design = true replaces is an error, unless it has its default value.
  template <typename T>
  static void refuse_designed_gains(const TomlNode& table, std::span<const NumberKey<T>> keys, const T& gains) {
    if constexpr (std::is_same_v<T, model::AltitudeGains>) {
      for (const NumberKey<T>& key : keys) {
        if (gains.design && is_designed(key.member) && gains.*key.member != T{}.*key.member) {
          table.get(key.key)->refuse("has no effect without design = false");
        }
      }
    }
  }

  const TomlNode& root_;
  VehicleFile& out_;
  std::set<std::string> known_;
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace m100::companion
