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
  file.sources["axis." + result.axis] = source;
  app::save_vehicle(path, file.vehicle, file.sources);
  return homeless;
}

}  // namespace m100::tools::identify
