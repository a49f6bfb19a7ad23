// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/vehicle_file.h"

#define TOML_ASSERT(condition) static_cast<void>(0)  // its debug checks abort on damaged input, which we refuse
#include <toml++/toml.h>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

namespace m100::app {
namespace {

using model::AltitudeGains;
using model::AttitudeAxis;
using model::DeadZoneShape;
using model::EstimatorNoise;
using model::MpcWeights;
using model::RateAxis;
using model::Translation;
using model::Vehicle;
using model::YawGain;

constexpr std::array kAttitudeKeys{
    NumberKey<AttitudeAxis>{"scale_rad_per_count", &AttitudeAxis::scale_rad_per_count, 1e-5, 1e-2},
    NumberKey<AttitudeAxis>{"time_constant_s", &AttitudeAxis::time_constant_s, 0.005, 5.0},
    NumberKey<AttitudeAxis>{"natural_frequency_rad_s", &AttitudeAxis::natural_frequency_rad_s, 0.5, 100.0},
    NumberKey<AttitudeAxis>{"damping_ratio", &AttitudeAxis::damping_ratio, 0.05, 5.0},
    NumberKey<AttitudeAxis>{"transport_delay_s", &AttitudeAxis::transport_delay_s, 0.0, 0.3},
    NumberKey<AttitudeAxis>{"lead_zero_s", &AttitudeAxis::lead_zero_s, -0.5, 0.5},
    NumberKey<AttitudeAxis>{"dead_zone_counts", &AttitudeAxis::dead_zone_counts, 0.0, 300.0},
    NumberKey<AttitudeAxis>{"trim_counts", &AttitudeAxis::trim_counts, -300.0, 300.0},
    NumberKey<AttitudeAxis>{"saturation_rad", &AttitudeAxis::saturation_rad, 0.0, 1.5},
    NumberKey<AttitudeAxis>{"rate_limit_rad_s", &AttitudeAxis::rate_limit_rad_s, 0.0, 50.0},
    NumberKey<AttitudeAxis>{"gain_asymmetry", &AttitudeAxis::gain_asymmetry, 0.2, 5.0},
    NumberKey<AttitudeAxis>{"stick_exponent", &AttitudeAxis::stick_exponent, 0.3, 4.0},
    NumberKey<AttitudeAxis>{"backlash_counts", &AttitudeAxis::backlash_counts, 0.0, 200.0},
    NumberKey<AttitudeAxis>{"gain_drift_per_minute", &AttitudeAxis::gain_drift_per_minute, -1.0, 1.0},
    NumberKey<AttitudeAxis>{"cross_axis", &AttitudeAxis::cross_axis, -1.0, 1.0},
};

/// Yaw rate and climb differ only in the names of three keys and in their ranges.
constexpr std::array<NumberKey<RateAxis>, 14> rate_keys(std::string_view scale, std::string_view limit,
                                                        std::string_view slew) {
  return {{{scale, &RateAxis::scale_per_count, 1e-5, 1e-1},
           {"time_constant_s", &RateAxis::time_constant_s, 0.005, 5.0},
           {"natural_frequency_rad_s", &RateAxis::natural_frequency_rad_s, 0.5, 100.0},
           {"damping_ratio", &RateAxis::damping_ratio, 0.05, 5.0},
           {"transport_delay_s", &RateAxis::transport_delay_s, 0.0, 0.5},
           {"dead_zone_counts", &RateAxis::dead_zone_counts, 0.0, 300.0},
           {"trim_counts", &RateAxis::trim_counts, -300.0, 300.0},
           {"stick_exponent", &RateAxis::stick_exponent, 0.3, 4.0},
           {limit, &RateAxis::limit, 0.0, 20.0},
           {slew, &RateAxis::rate_limit, 0.0, 100.0},
           {"gain_asymmetry", &RateAxis::gain_asymmetry, 0.2, 5.0},
           {"lead_zero_s", &RateAxis::lead_zero_s, -0.5, 0.5, true},
           {"backlash_counts", &RateAxis::backlash_counts, 0.0, 200.0, true},
           {"gain_drift_per_minute", &RateAxis::gain_drift_per_minute, -1.0, 1.0, true}}};
}
constexpr auto kYawRateKeys = rate_keys("scale_rad_s_per_count", "limit_rad_s", "rate_limit_rad_s2");
constexpr auto kClimbKeys = rate_keys("scale_m_s_per_count", "limit_m_s", "rate_limit_m_s2");

constexpr std::array kTranslationKeys{
    NumberKey<Translation>{"mass_kg", &Translation::mass_kg, 0.5, 20.0},
    NumberKey<Translation>{"linear_drag_per_s", &Translation::linear_drag_per_s, 0.0, 5.0},
    NumberKey<Translation>{"quadratic_drag_per_m", &Translation::quadratic_drag_per_m, 0.0, 2.0},
    NumberKey<Translation>{"tilt_limit_rad", &Translation::tilt_limit_rad, 0.05, 0.7},
    NumberKey<Translation>{"tilt_gain", &Translation::tilt_gain, 0.3, 3.0},
    NumberKey<Translation>{"thrust_gain", &Translation::thrust_gain, 0.3, 3.0},
    NumberKey<Translation>{"thrust_lag_s", &Translation::thrust_lag_s, 0.0, 1.0},
};
constexpr std::array kMpcKeys{
    NumberKey<MpcWeights>{"position", &MpcWeights::position, 1e-3, 1e6},
    NumberKey<MpcWeights>{"velocity", &MpcWeights::velocity, 0.0, 1e6},
    NumberKey<MpcWeights>{"tilt", &MpcWeights::tilt, 0.0, 1e6},
    NumberKey<MpcWeights>{"input", &MpcWeights::input, 1e-3, 1e6},
    NumberKey<MpcWeights>{"input_rate", &MpcWeights::input_rate, 0.0, 1e6},
};
constexpr std::array kEstimatorKeys{
    NumberKey<EstimatorNoise>{"position_process_m", &EstimatorNoise::position_process_m, 1e-7, 1.0},
    NumberKey<EstimatorNoise>{"velocity_process_m_s", &EstimatorNoise::velocity_process_m_s, 1e-6, 10.0},
    NumberKey<EstimatorNoise>{"tilt_process_rad", &EstimatorNoise::tilt_process_rad, 1e-7, 1.0},
    NumberKey<EstimatorNoise>{"tilt_rate_process_rad_s", &EstimatorNoise::tilt_rate_process_rad_s, 1e-6, 10.0},
    NumberKey<EstimatorNoise>{"disturbance_process_m_s2", &EstimatorNoise::disturbance_process_m_s2, 1e-6, 10.0},
    NumberKey<EstimatorNoise>{"input_offset_process_rad", &EstimatorNoise::input_offset_process_rad, 1e-7, 1.0},
    NumberKey<EstimatorNoise>{"pose_position_sigma_m", &EstimatorNoise::pose_position_sigma_m, 1e-5, 1.0},
    NumberKey<EstimatorNoise>{"pose_velocity_sigma_m_s", &EstimatorNoise::pose_velocity_sigma_m_s, 1e-4, 5.0},
    NumberKey<EstimatorNoise>{"attitude_sigma_rad", &EstimatorNoise::attitude_sigma_rad, 1e-5, 0.5},
    NumberKey<EstimatorNoise>{"rate_sigma_rad_s", &EstimatorNoise::rate_sigma_rad_s, 1e-4, 5.0},
};
constexpr std::array kAltitudeKeys{
    NumberKey<AltitudeGains>{"proportional_per_s", &AltitudeGains::proportional_per_s, 0.0, 20.0},
    NumberKey<AltitudeGains>{"integral_per_s2", &AltitudeGains::integral_per_s2, 0.0, 50.0},
    NumberKey<AltitudeGains>{"derivative", &AltitudeGains::derivative, 0.0, 5.0},
    NumberKey<AltitudeGains>{"integral_min_m_s", &AltitudeGains::integral_min_m_s, -4.0, 0.0},
    NumberKey<AltitudeGains>{"integral_max_m_s", &AltitudeGains::integral_max_m_s, 0.0, 4.0},
    NumberKey<AltitudeGains>{"climb_limit_m_s", &AltitudeGains::climb_limit_m_s, 0.1, 4.0},
};
constexpr std::array kYawKeys{
    NumberKey<YawGain>{"proportional_per_s", &YawGain::proportional_per_s, 0.0, 20.0},
    NumberKey<YawGain>{"rate_limit_rad_s", &YawGain::rate_limit_rad_s, 0.05, 1.7453},
};

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
    check_order(name, *table, into);
  }

  /// Names the first section that nobody reads.
  void refuse_unknown() const {
    for (const auto& [key, node] : root_) {
      const std::string name(key.str());
      if (name != "axis" && !known_.contains(name)) {
        fail(file_, &node, name, "unknown section");
      }
      if (name == "axis" && node.as_table() == nullptr) {
        fail(file_, &node, name, "must be a table");
      }
      if (name == "axis") {
        for (const auto& [axis, axis_node] : *node.as_table()) {
          if (!known_.contains("axis." + std::string(axis.str()))) {
            fail(file_, &axis_node, "axis." + std::string(axis.str()), "unknown axis");
          }
        }
      }
    }
  }

 private:
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
        const std::string shape = node.value<std::string>().value_or("");
        if (shape != "continuous" && shape != "jump") {
          fail(file_, &node, full, "must be \"continuous\" or \"jump\"");
        }
        into.dead_zone_shape = shape == "jump" ? DeadZoneShape::kJump : DeadZoneShape::kContinuous;
        return;
      }
    }
    for (const NumberKey<T>& known : keys) {
      if (known.key == key) {
        into.*known.member = number(node, full, known.low, known.high);
        return;
      }
    }
    fail(file_, &node, full, "unknown key");
  }

  double number(const toml::node& node, const std::string& full, double low, double high) const {
    if (!node.is_number()) {
      fail(file_, &node, full, "must be a number");
    }
    const double value = *node.value<double>();
    // Zero stands for "no such effect" in keys whose range begins above it (time constants and the like).
    const bool absent = value == 0.0 && low > 0.0 && low < 1.0 && full.find("scale") == std::string::npos;
    if (!absent && !(value >= low && value <= high)) {
      fail(file_, &node, full, shortest(value) + " is outside [" + shortest(low) + ", " + shortest(high) + "]");
    }
    return value;
  }

  /// An axis is of first order (time constant) or of second order (frequency and damping), never both or neither.
  template <typename T>
  void check_order(const std::string& name, const toml::table& table, const T& axis) const {
    if constexpr (requires { axis.natural_frequency_rad_s; }) {
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
      if (!(name == "axis.climb" ? table.contains("scale_m_s_per_count")
                                 : table.contains("scale_rad_per_count") || table.contains("scale_rad_s_per_count"))) {
        fail(file_, &table, name, "its scale per count is missing");
      }
    }
  }

  const toml::table& root_;
  const std::string& file_;
  VehicleFile& out_;
  std::set<std::string> known_;
};

/// Writes what Reader reads; the same tables, so that nothing can be written that is not read back.
class Writer {
 public:
  explicit Writer(const std::map<std::string, std::string>& sources) : sources_(sources) {}

  template <typename T>
  void section(const std::string& name, std::span<const NumberKey<T>> keys, const T& from) {
    if constexpr (requires { from.natural_frequency_rad_s; }) {
      if (!(from.time_constant_s > 0.0) && !(from.natural_frequency_rad_s > 0.0)) {
        return;  // nobody has identified this axis yet
      }
    }
    text_ << "[" << name << "]\n";
    for (const NumberKey<T>& key : keys) {
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

template <typename T, std::size_t kCount>
std::span<const NumberKey<T>> view(const std::array<NumberKey<T>, kCount>& keys) {
  return keys;
}

/// The one list of sections, in file order.
template <typename Visitor, typename VehicleRef>
void visit_sections(Visitor& visitor, VehicleRef& vehicle) {
  visitor.section("axis.roll", view(kAttitudeKeys), vehicle.roll);
  visitor.section("axis.pitch", view(kAttitudeKeys), vehicle.pitch);
  visitor.section("axis.yaw_rate", view(kYawRateKeys), vehicle.yaw_rate);
  visitor.section("axis.climb", view(kClimbKeys), vehicle.climb);
  visitor.section("translation", view(kTranslationKeys), vehicle.translation);
  visitor.section("mpc", view(kMpcKeys), vehicle.mpc);
  visitor.section("estimator", view(kEstimatorKeys), vehicle.estimator);
  visitor.section("altitude", view(kAltitudeKeys), vehicle.altitude);
  visitor.section("yaw", view(kYawKeys), vehicle.yaw);
}

}  // namespace

std::span<const NumberKey<AttitudeAxis>> attitude_axis_keys() { return kAttitudeKeys; }
std::span<const NumberKey<RateAxis>> yaw_rate_keys() { return kYawRateKeys; }
std::span<const NumberKey<RateAxis>> climb_keys() { return kClimbKeys; }

VehicleFile parse_vehicle(std::string_view text, const std::string& name) {
  VehicleFile file;
  toml::table root;
  try {
    root = toml::parse(text);
  } catch (const toml::parse_error& wrong) {
    throw VehicleFileError(name + ":" + std::to_string(wrong.source().begin.line) + ": " +
                           std::string(wrong.description()));
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
  std::ifstream stream(path, std::ios::binary);
  if (!stream) {
    throw VehicleFileError(path + ": cannot be opened");
  }
  std::ostringstream text;
  text << stream.rdbuf();
  return parse_vehicle(text.str(), path);
}

std::string to_text(const Vehicle& vehicle, const std::map<std::string, std::string>& sources) {
  Writer writer(sources);
  visit_sections(writer, vehicle);
  return writer.text();
}

VehicleFile save_vehicle(const std::string& path, const Vehicle& vehicle,
                         const std::map<std::string, std::string>& sources) {
  const std::string text = to_text(vehicle, sources);
  VehicleFile file = parse_vehicle(text, path);  // what cannot be read back is not written
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

}  // namespace m100::app
