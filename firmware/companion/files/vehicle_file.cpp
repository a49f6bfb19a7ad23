// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/vehicle_file.h"

#include <fstream>
#include <span>
#include <sstream>
#include <type_traits>

#include "firmware/companion/files/text/regular_file.h"
#include "firmware/companion/files/vehicle_keys.h"
#include "firmware/companion/files/vehicle_reader.h"

namespace m100::companion {
namespace {

using model::AxisUnit;
using model::DeadZoneShape;
using model::Vehicle;

/// Writes what VehicleReader reads, from the same tables, so that everything written can be read back.
class Writer {
 public:
  explicit Writer(const VehicleFile& file) : file_(file) {}

  template <typename T>
  void optional_section(const std::string& name, std::span<const NumberKey<T>> keys, const T& from, bool exists) {
    if (exists) {
      section(name, keys, from);
    }
  }

  void rivals() {
    for (const Rival& rival : file_.rivals) {
      text_ << "[[rival]]\naxis = \"" << rival.axis << "\"\n";
      if (rival.probability > 0.0) {
        text_ << "probability = " << shortest_number(rival.probability) << "\n";
      }
      numbers(axis_keys(AxisUnit::kTilt_rad), rival.numbers);
      text_ << intervals_text(rival.intervals) << source_text(rival.source) << "\n";
    }
  }

  template <typename T>
  void section(const std::string& name, std::span<const NumberKey<T>> keys, const T& from) {
    if constexpr (std::is_same_v<T, model::StickAxis>) {
      if (!from.is_identified()) {
        return;  // an axis that was not identified has no section
      }
    }
    text_ << "[" << name << "]\n";
    numbers(keys, from);
    if (file_.intervals.contains(name)) {
      text_ << intervals_text(file_.intervals.at(name));
    }
    text_ << source_text(file_.sources.contains(name) ? file_.sources.at(name) : "") << "\n";
  }
  std::string text() const { return text_.str(); }

 private:
  template <typename T>
  void numbers(std::span<const NumberKey<T>> keys, const T& from) {
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
        text_ << key.key << " = " << shortest_number(from.*key.member) << "\n";
      }
    }
    if constexpr (requires { from.dead_zone_shape; }) {
      text_ << kDeadZoneShapeKey << " = \""
            << kDeadZoneShapes[from.dead_zone_shape == DeadZoneShape::kJump ? 1 : 0].word << "\"\n";
    }
  }
  static std::string intervals_text(const Intervals& intervals) {
    std::string out;
    for (const auto& [key, interval] : intervals) {
      out += key + "_low = " + shortest_number(interval.low) + "\n" + key +
             "_high = " + shortest_number(interval.high) + "\n";
    }
    return out;
  }
  static std::string source_text(const std::string& source) {
    return source.empty() ? "" : toml_line("source", source);
  }

  const VehicleFile& file_;
  std::ostringstream text_;
};

template <typename Visitor, typename DesignRef>
void visit_design(Visitor& visitor, const std::string& name, DesignRef& design) {
  visitor.section(name + ".roll", axis_keys(AxisUnit::kTilt_rad), design.roll);
  visitor.section(name + ".pitch", axis_keys(AxisUnit::kTilt_rad), design.pitch);
  visitor.optional_section(name + ".mpc", mpc_keys(), design.mpc, design.has_mpc);
  visitor.optional_section(name + ".estimator", estimator_keys(), design.estimator, design.has_estimator);
}

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
  if constexpr (!std::is_const_v<VehicleRef>) {  // a number that [design] does not have is the vehicle's own
    for (model::Design* design : {&vehicle.design, &vehicle.robust}) {
      design->mpc = vehicle.mpc;
      design->estimator = vehicle.estimator;
    }
  }
  visit_design(visitor, "design", vehicle.design);
  visit_design(visitor, "design.robust", vehicle.robust);
  visitor.rivals();
}

}  // namespace

VehicleFile parse_vehicle(std::string_view text, const std::string& name) {
  VehicleFile file;
  const TomlNode root = parse_toml(text, name);
  if (root.entries().empty()) {
    root.refuse("the file is empty");
  }
  VehicleReader reader(root, file);
  visit_sections(reader, file.vehicle);
  reader.refuse_unknown();
  file.digest = core::sha256(std::as_bytes(std::span(text.data(), text.size())));
  return file;
}

VehicleFile load_vehicle(const std::string& path) {
  const FileContent content = read_regular(path, kMaxTextBytes);
  if (!content.why_not.empty()) {
    throw FileError(path + ": " + content.why_not);
  }
  return parse_vehicle(content.bytes, path);
}

std::string to_text(const Vehicle& vehicle, const std::map<std::string, std::string>& sources) {
  VehicleFile file;
  file.vehicle = vehicle;
  file.sources = sources;
  return to_text(file);
}

std::string to_text(const VehicleFile& file) {
  Writer writer(file);
  visit_sections(writer, file.vehicle);
  return writer.text();
}

VehicleFile save_vehicle(const std::string& path, const VehicleFile& from) {
  const std::string text = to_text(from);
  VehicleFile file = parse_vehicle(text, path);  // a text that cannot be read back is not written
  std::ofstream stream(path, std::ios::binary);
  stream << text;
  stream.flush();
  if (!stream) {
    throw FileError(path + ": cannot be written");
  }
  return file;
}

VehicleFile save_vehicle(const std::string& path, const Vehicle& vehicle,
                         const std::map<std::string, std::string>& sources) {
  VehicleFile file;
  file.vehicle = vehicle;
  file.sources = sources;
  return save_vehicle(path, file);
}

VehicleFile as_file(const Vehicle& vehicle, const std::map<std::string, std::string>& sources) {
  return parse_vehicle(to_text(vehicle, sources), "(vehicle in memory)");
}

}  // namespace m100::companion
