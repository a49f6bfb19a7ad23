// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/tools/identify/translation_regression.h"

namespace m100::tools::identify::translation {

// steady_wind and body_bias: m/s^2; drags 1/s and 1/m; gains: difference to one; lag, offset: s; angle: rad; periodic:
// m/s^2
const std::vector<Effect>& effects() {
  static const std::vector<Effect> kEffects{
      {"steady_wind", {"accel_x_m_s2", "accel_y_m_s2"}, 0.06},
      {"body_bias", {"accel_x_m_s2", "accel_y_m_s2"}, 0.06},
      {"linear_drag", {"rate_per_s"}, 0.03},
      {"quadratic_drag", {"coefficient_per_m"}, 0.008},
      {"tilt_gain", {"gain"}, 0.03},
      {"thrust_gain", {"gain"}, 0.01},
      {"thrust_lag", {"lag_s"}, 0.012},
      {"axial_inflow", {"coefficient_per_s"}, 0.03},
      {"time_offset", {"offset_s"}, 0.012},
      {"yaw_misalignment", {"angle_rad"}, 0.03},
      {"periodic_wind", {"frequency_hz", "amplitude_x_m_s2", "amplitude_y_m_s2"}, 0.05}};
  return kEffects;
}

const Effect* effect_named(const std::string& name) {
  const auto found = std::find_if(effects().begin(), effects().end(), [&](const Effect& e) { return name == e.name; });
  return found == effects().end() ? nullptr : &*found;
}

bool has(const Structure& structure, const char* name) {
  return std::find(structure.begin(), structure.end(), name) != structure.end();
}

Searched as_searched(std::span<const double> v) { return {v[0], v[1], v[2], v[3], v[4], v[5]}; }

bool wind_speed_matters(const Structure& structure) {
  return has(structure, "steady_wind") && has(structure, "quadratic_drag");
}

std::array<bool, kSearched> searched_in(const Structure& structure) {
  const bool wind = wind_speed_matters(structure);
  return {has(structure, "thrust_lag"),      has(structure, "time_offset"), has(structure, "periodic_wind"), wind, wind,
          has(structure, "yaw_misalignment")};
}

std::size_t linear_count(const Structure& structure, const std::string& name) {
  if (name == "rigid_body" || name == "thrust_lag" || name == "time_offset" || name == "yaw_misalignment") {
    return 0;
  }
  if (name == "periodic_wind") {
    return 4;
  }
  if (name == "steady_wind") {
    return wind_speed_matters(structure) ? 0 : 2;
  }
  return name == "body_bias" ? 2 : 1;
}

std::size_t linear_count(const Structure& structure) {
  std::size_t count = 0;
  for (const std::string& name : structure) {
    count += linear_count(structure, name);
  }
  return count;
}

std::size_t column_of(const Structure& structure, const std::string& wanted) {
  std::size_t column = 0;
  for (const std::string& name : structure) {
    if (name == wanted) {
      break;
    }
    column += linear_count(structure, name);
  }
  return column;
}

}  // namespace m100::tools::identify::translation
