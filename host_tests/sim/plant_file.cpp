// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/plant_file.h"

#define TOML_ASSERT(condition) static_cast<void>(0)  // its debug checks abort on damaged input, which we refuse
#include <toml++/toml.h>
#include <array>
#include <fstream>
#include <set>
#include <span>
#include <sstream>

#include "firmware/app/vehicle_file.h"

namespace m100::sim {
namespace {

using app::NumberKey;

constexpr std::array kAirKeys{
    NumberKey<Air>{"linear_drag_per_s", &Air::linear_drag_per_s, 0.0, 5.0},
    NumberKey<Air>{"quadratic_drag_per_m", &Air::quadratic_drag_per_m, 0.0, 2.0},
    NumberKey<Air>{"gust_m_s", &Air::gust_m_s, 0.0, 20.0},
    NumberKey<Air>{"gust_hz", &Air::gust_hz, 0.0, 20.0},
    NumberKey<Air>{"turbulence_m_s", &Air::turbulence_m_s, 0.0, 20.0},
    NumberKey<Air>{"turbulence_length_m", &Air::turbulence_length_m, 0.05, 1000.0},
    NumberKey<Air>{"attitude_disturbance_rad", &Air::attitude_disturbance_rad, 0.0, 0.2},
    NumberKey<Air>{"climb_disturbance_m_s", &Air::climb_disturbance_m_s, 0.0, 2.0},
    NumberKey<Air>{"yaw_rate_disturbance_rad_s", &Air::yaw_rate_disturbance_rad_s, 0.0, 2.0},
};
constexpr std::array kPayloadKeys{
    NumberKey<Payload>{"mass_kg", &Payload::mass_kg, 0.0, 10.0},
    NumberKey<Payload>{"slung_length_m", &Payload::slung_length_m, 0.0, 50.0},
};
constexpr std::array kSensorKeys{
    NumberKey<Sensors>{"pose_noise_m", &Sensors::pose_noise_m, 0.0, 1.0},
    NumberKey<Sensors>{"pose_yaw_noise_rad", &Sensors::pose_yaw_noise_rad, 0.0, 0.5},
    NumberKey<Sensors>{"pose_delay_s", &Sensors::pose_delay_s, 0.0, 0.5},
    NumberKey<Sensors>{"pose_dropout_per_s", &Sensors::pose_dropout_per_s, 0.0, 100.0},
    NumberKey<Sensors>{"pose_dropout_s", &Sensors::pose_dropout_s, 0.0, 10.0},
    NumberKey<Sensors>{"attitude_noise_rad", &Sensors::attitude_noise_rad, 0.0, 0.5},
    NumberKey<Sensors>{"imu_rate_noise_rad_s", &Sensors::imu_rate_noise_rad_s, 0.0, 1.0},
    NumberKey<Sensors>{"imu_acceleration_noise_m_s2", &Sensors::imu_acceleration_noise_m_s2, 0.0, 10.0},
};
constexpr std::array kLinkKeys{
    NumberKey<Link>{"baud", &Link::baud, 9600.0, 4e6},
    NumberKey<Link>{"command_delay_s", &Link::command_delay_s, 0.0, 0.5},
    NumberKey<Link>{"drop", &Link::drop, 0.0, 1.0},
    NumberKey<Link>{"bit_error_rate", &Link::bit_error_rate, 0.0, 0.1},
};
constexpr std::array kBatteryKeys{NumberKey<Battery>{"sag", &Battery::sag, 0.0, 0.9}};
constexpr std::array kVehicleKeys{NumberKey<Plant>{"mass_kg", &Plant::mass_kg, 0.5, 20.0}};

class Reader {
 public:
  Reader(const toml::table& root, const std::string& file) : root_(root), file_(file) {}

  /// The section's table, or nothing where the file has none.
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

  template <typename T>
  void axis(const std::string& name, std::span<const NumberKey<T>> keys, T& into) {
    const toml::table* const table = section(name);
    if (table == nullptr) {
      return;
    }
    into = T{};  // a key that is missing here is an effect that is absent
    for (const auto& [key, node] : *table) {
      if (key == "dead_zone_shape") {
        const std::string shape = node.template value<std::string>().value_or("");
        if (shape != "continuous" && shape != "jump") {
          fail(node, name + ".dead_zone_shape", "must be \"continuous\" or \"jump\"");
        }
        into.dead_zone_shape = shape == "jump" ? model::DeadZoneShape::kJump : model::DeadZoneShape::kContinuous;
      } else {
        number(name, key.str(), node, keys, into);
      }
    }
    const bool first = into.time_constant_s > 0.0;
    const bool second = into.natural_frequency_rad_s > 0.0;
    if (first == second) {
      fail(*table, name, "give either time_constant_s or natural_frequency_rad_s with damping_ratio");
    }
    if (second && !(into.damping_ratio > 0.0)) {
      fail(*table, name + ".damping_ratio", "missing beside natural_frequency_rad_s");
    }
    if (!table->contains(keys.front().key)) {
      fail(*table, name + "." + std::string(keys.front().key), "missing");
    }
  }

  void wind(Air& air) {
    const toml::table* const table = section("air");
    if (table == nullptr) {
      return;
    }
    for (const auto& [key, node] : *table) {
      if (key != "wind_m_s") {
        number<Air>("air", key.str(), node, kAirKeys, air);
        continue;
      }
      const toml::array* const entries = node.as_array();
      if (entries == nullptr || entries->size() != 3) {
        fail(node, "air.wind_m_s", "must be three numbers [x, y, z]");
      }
      for (std::size_t i = 0; i < 3; ++i) {
        air.wind_m_s[static_cast<Eigen::Index>(i)] = in_range(*entries->get(i), "air.wind_m_s", -40.0, 40.0);
      }
    }
  }

  void refuse_unknown() const {
    for (const auto& [key, node] : root_) {
      const std::string name(key.str());
      if (name == "axis" && node.is_table()) {
        for (const auto& [axis, axis_node] : *node.as_table()) {
          if (!known_.contains("axis." + std::string(axis.str()))) {
            fail(axis_node, "axis." + std::string(axis.str()), "unknown axis");
          }
        }
      } else if (!known_.contains(name)) {
        fail(node, name, "unknown section");
      }
    }
  }

 private:
  [[noreturn]] void fail(const toml::node& node, const std::string& key, const std::string& what) const {
    throw PlantFileError(file_ + ":" + std::to_string(node.source().begin.line) + ": '" + key + "': " + what);
  }

  template <typename T>
  void number(const std::string& section, std::string_view key, const toml::node& node,
              std::span<const NumberKey<T>> keys, T& into) const {
    const std::string full = section + "." + std::string(key);
    if (key == "source" && node.is_string()) {
      return;
    }
    for (const NumberKey<T>& known : keys) {
      if (known.key == key) {
        into.*known.member = in_range(node, full, known.low, known.high);
        return;
      }
    }
    fail(node, full, "unknown key");
  }

  double in_range(const toml::node& node, const std::string& key, double low, double high) const {
    if (!node.is_number()) {
      fail(node, key, "must be a number");
    }
    const double value = *node.value<double>();
    const bool absent = value == 0.0 && low < 1.0 && key.find("scale") == std::string::npos;
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

Plant parse_plant(std::string_view text, const std::string& name) {
  toml::table root;
  try {
    root = toml::parse(text);
  } catch (const toml::parse_error& wrong) {
    throw PlantFileError(name + ":" + std::to_string(wrong.source().begin.line) + ": " +
                         std::string(wrong.description()));
  }
  if (root.empty()) {
    throw PlantFileError(name + ": the file is empty");
  }
  Plant plant = measured_plant();
  Reader reader(root, name);
  reader.axis("axis.roll", app::attitude_axis_keys(), plant.roll);
  reader.axis("axis.pitch", app::attitude_axis_keys(), plant.pitch);
  reader.axis("axis.yaw_rate", app::yaw_rate_keys(), plant.yaw_rate);
  reader.axis("axis.climb", app::climb_keys(), plant.climb);
  reader.wind(plant.air);
  reader.numbers<Payload>("payload", kPayloadKeys, plant.payload);
  reader.numbers<Sensors>("sensors", kSensorKeys, plant.sensors);
  reader.numbers<Link>("link", kLinkKeys, plant.link);
  reader.numbers<Battery>("battery", kBatteryKeys, plant.battery);
  reader.numbers<Plant>("vehicle", kVehicleKeys, plant);
  reader.refuse_unknown();
  return plant;
}

Plant load_plant(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) {
    throw PlantFileError(path + ": cannot be opened");
  }
  std::ostringstream text;
  text << stream.rdbuf();
  return parse_plant(text.str(), path);
}

}  // namespace m100::sim
