// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/vehicle_file.h"

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <span>
#include <sstream>
#include <type_traits>

#include "firmware/companion/files/text/regular_file.h"
#include "firmware/companion/files/text/suggestion.h"
#include "firmware/companion/files/text/toml_text.h"
#include "firmware/companion/files/vehicle_keys.h"

namespace m100::companion {
namespace {

using model::AxisUnit;
using model::DeadZoneShape;
using model::Vehicle;

std::string shortest(double value) {
  std::array<char, 32> buffer{};
  const std::to_chars_result end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  std::string text(buffer.data(), end.ptr);
  return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;  // TOML: a float needs a point
}

[[noreturn]] void fail(const std::string& file, const toml::node* node, const std::string& key,
                       const std::string& what) {
  const auto line = node == nullptr ? 0U : node->source().begin.line;
  throw VehicleFileError(file + (line > 0 ? ":" + std::to_string(line) : "") + ": '" + key + "': " + what);
}

constexpr std::string_view kShapeKey = "dead_zone_shape";
constexpr std::string_view kDesignKey = "design";

/// The height gains that altitude.design computes: they have no effect where it is true.
bool is_designed(double model::AltitudeGains::*member) {
  using Gains = model::AltitudeGains;
  return member == &Gains::proportional_per_s || member == &Gains::integral_per_s2 || member == &Gains::derivative;
}

/// Reads the sections of one file into one struct.
class Reader {
 public:
  Reader(const toml::table& root, const std::string& file, VehicleFile& out) : root_(root), file_(file), out_(out) {}

  template <typename T>
  void section(const std::string& name, std::span<const NumberKey<T>> keys, T& into) {
    const toml::node_view<const toml::node> view = root_.at_path(name);
    known_.insert(name);
    if (!view) {
      return;
    }
    const toml::table* table = view.as_table();
    if (table == nullptr) {
      fail(file_, view.node(), name, "must be a table");
    }
    out_.sections.insert(name);
    for (const auto& [key, node] : *table) {
      read_key(name, std::string(key.str()), node, keys, into);
    }
    check_order(name, *table, keys, into);
    refuse_designed_gains(name, *table, keys, into);
  }

  /// Refuses the first unknown section.
  void refuse_unknown() const {
    for (const auto& [key, node] : root_) {
      const std::string name(key.str());
      if (name != "axis" && !known_.contains(name)) {
        fail(file_, &node, name, "unknown section" + section_meant(name, known_));
      }
      if (name == "axis" && node.as_table() == nullptr) {
        fail(file_, &node, name, "must be a table");
      }
      if (name == "axis") {
        refuse_unknown_axes(*node.as_table());
      }
    }
  }

 private:
  void refuse_unknown_axes(const toml::table& axes) const {
    for (const auto& [axis, node] : axes) {
      const std::string name = "axis." + std::string(axis.str());
      if (!known_.contains(name)) {
        fail(file_, &node, name, "unknown axis" + did_you_mean(name, known_));
      }
    }
  }
  template <typename T>
  void read_key(const std::string& section, const std::string& key, const toml::node& node,
                std::span<const NumberKey<T>> keys, T& into) {
    const std::string full = section + "." + key;
    if (key == "source") {
      if (!node.is_string()) {
        fail(file_, &node, full, "must be a text");
      }
      out_.sources[section] = *node.value<std::string>();
      return;
    }
    if constexpr (requires { into.dead_zone_shape; }) {
      if (key == kShapeKey) {
        into.dead_zone_shape = shape(node, full);
        return;
      }
    }
    if constexpr (requires { into.design; }) {
      if (key == kDesignKey) {
        if (!node.is_boolean()) {
          fail(file_, &node, full, "must be true or false");
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
    fail(file_, &node, full, "unknown key" + did_you_mean(key, keys, &NumberKey<T>::key));
  }

  DeadZoneShape shape(const toml::node& node, const std::string& full) const {
    const std::string word = node.value<std::string>().value_or("");
    if (word != "continuous" && word != "jump") {
      fail(file_, &node, full, "must be \"continuous\" or \"jump\"");
    }
    return word == "jump" ? DeadZoneShape::kJump : DeadZoneShape::kContinuous;
  }

  double number(const toml::node& node, const std::string& full, double low, double high, bool may_be_absent) const {
    if (!node.is_number()) {
      fail(file_, &node, full, "must be a number");
    }
    const double value = *node.value<double>();
    // Zero means "no such effect" in keys whose default it is, although their range begins above it.
    const bool absent = value == 0.0 && may_be_absent && full.find("scale") == std::string::npos;
    if (!absent && !(value >= low && value <= high)) {
      fail(file_, &node, full, shortest(value) + " is outside [" + shortest(low) + ", " + shortest(high) + "]");
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
        fail(file_, table.get("time_constant_s"), name + ".time_constant_s",
             "an axis has a time constant or a natural frequency, not both");
      }
      if (!first && !second) {
        fail(file_, &table, name + ".time_constant_s",
             "missing: give it, or natural_frequency_rad_s and damping_ratio");
      }
      if (second && !(axis.damping_ratio > 0.0)) {
        fail(file_, &table, name + ".damping_ratio", "missing beside natural_frequency_rad_s");
      }
      if (!table.contains(keys.front().key)) {
        fail(file_, &table, name, "its scale per count is missing");
      }
    }
  }

  /// A gain that would never fly is an error. The paper's own are accepted: earlier files wrote them without effect.
  template <typename T>
  void refuse_designed_gains(const std::string& name, const toml::table& table, std::span<const NumberKey<T>> keys,
                             const T& gains) const {
    if constexpr (std::is_same_v<T, model::AltitudeGains>) {
      for (const NumberKey<T>& key : keys) {
        if (gains.design && is_designed(key.member) && gains.*key.member != T{}.*key.member) {
          fail(file_, table.get(key.key), name + "." + std::string(key.key), "has no effect without design = false");
        }
      }
    }
  }

  const toml::table& root_;
  const std::string& file_;
  VehicleFile& out_;
  std::set<std::string> known_;
};

/// Writes what Reader reads, from the same tables, so that everything written can be read back.
class Writer {
 public:
  explicit Writer(const std::map<std::string, std::string>& sources) : sources_(sources) {}

  template <typename T>
  void section(const std::string& name, std::span<const NumberKey<T>> keys, const T& from) {
    if constexpr (std::is_same_v<T, model::StickAxis>) {
      if (!from.is_identified()) {
        return;  // nobody has identified this axis yet
      }
    }
    text_ << "[" << name << "]\n";
    if constexpr (requires { from.design; }) {
      text_ << (from.design ? "" : std::string(kDesignKey) + " = false\n");
    }
    for (const NumberKey<T>& key : keys) {
      if constexpr (requires { from.design; }) {
        if (from.design && is_designed(key.member)) {
          continue;
        }
      }
      if (key.only_if_set && from.*key.member == T{}.*key.member) {
        continue;
      }
      if (from.*key.member != T{}.*key.member || key.low <= 0.0 || key.low >= 1.0 || from.*key.member != 0.0) {
        text_ << key.key << " = " << shortest(from.*key.member) << "\n";
      }
    }
    if constexpr (requires { from.dead_zone_shape; }) {
      text_ << kShapeKey << " = \"" << (from.dead_zone_shape == DeadZoneShape::kJump ? "jump" : "continuous") << "\"\n";
    }
    if (const auto source = sources_.find(name); source != sources_.end()) {
      toml::table quoted;
      quoted.insert("source", source->second);
      text_ << quoted << "\n";
    }
    text_ << "\n";
  }
  std::string text() const { return text_.str(); }

 private:
  const std::map<std::string, std::string>& sources_;
  std::ostringstream text_;
};

/// Visits all sections in file order; reader and writer share this list.
template <typename Visitor, typename VehicleRef>
void visit_sections(Visitor& visitor, VehicleRef& vehicle) {
  visitor.section("axis.roll", axis_keys(AxisUnit::kTilt_rad), vehicle.roll);
  visitor.section("axis.pitch", axis_keys(AxisUnit::kTilt_rad), vehicle.pitch);
  visitor.section("axis.yaw_rate", axis_keys(AxisUnit::kYawRate_rad_s), vehicle.yaw_rate);
  visitor.section("axis.climb", axis_keys(AxisUnit::kClimb_m_s), vehicle.climb);
  visitor.section("translation", translation_keys(), vehicle.translation);
  visitor.section("mpc", mpc_keys(), vehicle.mpc);
  visitor.section("estimator", estimator_keys(), vehicle.estimator);
  visitor.section("altitude", altitude_keys(), vehicle.altitude);
  visitor.section("yaw", yaw_keys(), vehicle.yaw);
}

}  // namespace

VehicleFile parse_vehicle(std::string_view text, const std::string& name) {
  VehicleFile file;
  toml::table root;
  try {
    root = parse_toml(text);
  } catch (const TomlTextError& wrong) {
    throw VehicleFileError(name + ":" + std::to_string(wrong.line) + ": " + wrong.what());
  }
  if (root.empty()) {
    throw VehicleFileError(name + ": the file is empty");
  }
  Reader reader(root, name, file);
  visit_sections(reader, file.vehicle);
  reader.refuse_unknown();
  file.digest = core::sha256(std::as_bytes(std::span(text.data(), text.size())));
  return file;
}

VehicleFile load_vehicle(const std::string& path) {
  const FileContent content = read_regular(path, kMaxTextBytes);
  if (!content.why_not.empty()) {
    throw VehicleFileError(path + ": " + content.why_not);
  }
  return parse_vehicle(content.bytes, path);
}

std::string to_text(const Vehicle& vehicle, const std::map<std::string, std::string>& sources) {
  Writer writer(sources);
  visit_sections(writer, vehicle);
  return writer.text();
}

VehicleFile save_vehicle(const std::string& path, const Vehicle& vehicle,
                         const std::map<std::string, std::string>& sources) {
  const std::string text = to_text(vehicle, sources);
  VehicleFile file = parse_vehicle(text, path);  // a text that cannot be read back is not written
  std::ofstream stream(path, std::ios::binary);
  stream << text;
  stream.flush();
  if (!stream) {
    throw VehicleFileError(path + ": cannot be written");
  }
  return file;
}

VehicleFile as_file(const Vehicle& vehicle, const std::map<std::string, std::string>& sources) {
  return parse_vehicle(to_text(vehicle, sources), "(vehicle in memory)");
}

}  // namespace m100::companion
