// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/tools/identify/to_vehicle.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <span>

#include "firmware/app/vehicle_file.h"

namespace m100::tools::identify {
namespace {

template <typename Axis>
struct Place {
  const char* parameter;
  double Axis::*member;
};

constexpr Place<model::AttitudeAxis> kAttitudePlaces[] = {
    {"gain", &model::AttitudeAxis::scale_rad_per_count},
    {"time_constant_s", &model::AttitudeAxis::time_constant_s},
    {"natural_frequency_rad_s", &model::AttitudeAxis::natural_frequency_rad_s},
    {"damping_ratio", &model::AttitudeAxis::damping_ratio},
    {"delay_s", &model::AttitudeAxis::transport_delay_s},
    {"zero_s", &model::AttitudeAxis::lead_zero_s},
    {"width_counts", &model::AttitudeAxis::dead_zone_counts},
    {"offset_counts", &model::AttitudeAxis::trim_counts},
    {"limit", &model::AttitudeAxis::saturation_rad},
    {"limit_per_s", &model::AttitudeAxis::rate_limit_rad_s},
    {"ratio", &model::AttitudeAxis::gain_asymmetry},
    {"exponent", &model::AttitudeAxis::stick_exponent},
    {"half_width_counts", &model::AttitudeAxis::backlash_counts},
    {"fraction_per_minute", &model::AttitudeAxis::gain_drift_per_minute},
    {"coefficient", &model::AttitudeAxis::cross_axis},
};
constexpr Place<model::RateAxis> kRatePlaces[] = {
    {"gain", &model::RateAxis::scale_per_count},
    {"time_constant_s", &model::RateAxis::time_constant_s},
    {"natural_frequency_rad_s", &model::RateAxis::natural_frequency_rad_s},
    {"damping_ratio", &model::RateAxis::damping_ratio},
    {"delay_s", &model::RateAxis::transport_delay_s},
    {"width_counts", &model::RateAxis::dead_zone_counts},
    {"offset_counts", &model::RateAxis::trim_counts},
    {"limit", &model::RateAxis::limit},
    {"limit_per_s", &model::RateAxis::rate_limit},
    {"ratio", &model::RateAxis::gain_asymmetry},
    {"exponent", &model::RateAxis::stick_exponent},
    {"zero_s", &model::RateAxis::lead_zero_s},
    {"half_width_counts", &model::RateAxis::backlash_counts},
    {"fraction_per_minute", &model::RateAxis::gain_drift_per_minute},
};

// The axis starts from nothing: what was not found is not there.
template <typename Axis, std::size_t kCount>
std::vector<std::string> put(const IdentifyResult& result, const Place<Axis> (&places)[kCount],
                             std::span<const app::NumberKey<Axis>> keys, Axis& axis) {
  std::vector<std::string> homeless;
  axis = Axis{};
  axis.natural_frequency_rad_s = 0.0;
  axis.damping_ratio = 0.0;
  for (const NamedValue& parameter : result.final_model.parameters) {
    const auto* place = std::find_if(std::begin(places), std::end(places),
                                     [&](const Place<Axis>& one) { return parameter.name == one.parameter; });
    if (parameter.name == "other_gain") {
      continue;  // of the other axis, which has a section of its own
    }
    if (place == std::end(places)) {
      homeless.push_back("the vehicle file has no place for " + parameter.name + " of axis " + result.axis);
    } else {
      const double wanted = parameter.name == "gain" ? std::abs(parameter.value) : parameter.value;
      const auto key = std::find_if(keys.begin(), keys.end(),
                                    [&](const app::NumberKey<Axis>& one) { return one.member == place->member; });
      const double written = key == keys.end() ? wanted : std::clamp(wanted, key->low, key->high);
      if (written != wanted) {
        homeless.push_back("the vehicle file cannot hold " + parameter.name + " = " + std::to_string(wanted) +
                           " of axis " + result.axis + "; it says " + std::to_string(written));
      }
      axis.*(place->member) = written;
    }
  }
  if (result.final_model.dead_zone_shape == "jump") {
    axis.dead_zone_shape = model::DeadZoneShape::kJump;
  }
  return homeless;
}

struct TranslationPlace {
  const char* effect;
  std::size_t parameters;
  double model::Translation::*member;  ///< null: not a property of the vehicle
  const char* instead;                 ///< why not
  double low, high;
};

constexpr const char* kAir = "is the air of that flight: the observer estimates it in every flight anew";
constexpr const char* kLog = "belongs to the log, not to the vehicle";
constexpr TranslationPlace kTranslationPlaces[] = {
    {"linear_drag", 1, &model::Translation::linear_drag_per_s, nullptr, 0.0, 5.0},
    {"quadratic_drag", 1, &model::Translation::quadratic_drag_per_m, nullptr, 0.0, 2.0},
    {"tilt_gain", 1, &model::Translation::tilt_gain, nullptr, 0.3, 3.0},
    {"thrust_gain", 1, &model::Translation::thrust_gain, nullptr, 0.3, 3.0},
    {"thrust_lag", 1, &model::Translation::thrust_lag_s, nullptr, 0.0, 1.0},
    {"steady_wind", 2, nullptr, kAir, 0.0, 0.0},
    {"periodic_wind", 3, nullptr, kAir, 0.0, 0.0},
    {"body_bias", 2, nullptr, "has no place in the vehicle file: trim the vehicle; the observer carries it", 0.0, 0.0},
    {"axial_inflow", 1, nullptr, "has no place in the vehicle file: the height loop hides it", 0.0, 0.0},
    {"time_offset", 1, nullptr, kLog, 0.0, 0.0},
    {"yaw_misalignment", 1, nullptr, kLog, 0.0, 0.0},
};

// What was not found is not there, but mass and tilt limit were not asked about.
std::vector<std::string> put_translation(const IdentifyResult& result, model::Translation& translation) {
  std::vector<std::string> homeless;
  const model::Translation old = translation;
  translation =
      model::Translation{.mass_kg = old.mass_kg, .linear_drag_per_s = 0.0, .tilt_limit_rad = old.tilt_limit_rad};
  std::size_t parameter = 0;
  for (const std::string& effect : result.final_model.structure) {
    const auto* place = std::find_if(std::begin(kTranslationPlaces), std::end(kTranslationPlaces),
                                     [&](const TranslationPlace& one) { return effect == one.effect; });
    if (place == std::end(kTranslationPlaces)) {
      continue;  // rigid_body
    }
    if (place->member != nullptr) {
      translation.*(place->member) =
          std::clamp(result.final_model.parameters[parameter].value, place->low, place->high);
    } else {
      homeless.push_back(effect + " " + place->instead);
    }
    parameter += place->parameters;
  }
  return homeless;
}

}  // namespace

std::vector<std::string> put_axis(const IdentifyResult& result, model::Vehicle& vehicle) {
  if (result.axis == "roll" || result.axis == "pitch") {
    std::vector<std::string> homeless =
        put(result, kAttitudePlaces, app::attitude_axis_keys(), result.axis == "roll" ? vehicle.roll : vehicle.pitch);
    for (const NamedValue& parameter : result.final_model.parameters) {
      if (parameter.name == "limit_rad") {
        vehicle.translation.tilt_limit_rad = std::clamp(parameter.value, 0.05, 0.7);
        std::erase_if(homeless, [](const std::string& one) { return one.find("limit_rad") != std::string::npos; });
      }
    }
    return homeless;
  }
  if (result.axis == "translation") {
    return put_translation(result, vehicle.translation);
  }
  return result.axis == "climb" ? put(result, kRatePlaces, app::climb_keys(), vehicle.climb)
                                : put(result, kRatePlaces, app::yaw_rate_keys(), vehicle.yaw_rate);
}

std::vector<std::string> update_vehicle_file(const std::string& path, const IdentifyResult& result,
                                             const std::string& source) {
  app::VehicleFile file;
  if (std::filesystem::exists(path)) {
    file = app::load_vehicle(path);
  }
  const std::vector<std::string> homeless = put_axis(result, file.vehicle);
  file.sources[(result.axis == "translation" ? "" : "axis.") + result.axis] = source;
  app::save_vehicle(path, file.vehicle, file.sources);
  return homeless;
}

}  // namespace m100::tools::identify
