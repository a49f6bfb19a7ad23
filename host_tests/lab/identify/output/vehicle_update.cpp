// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/output/vehicle_update.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "firmware/companion/files/vehicle_file.h"
#include "firmware/model/axis_effects.h"

namespace m100::lab::identify {
namespace {

using model::AxisUnit;
using model::StickAxis;

/// The row of a parameter of a model, found by its name among the effects of the structure; null: none has this name.
const model::AxisNumber* row_of(const ModelResult& found, const std::string& parameter) {
  for (const std::string& name : found.structure) {
    const model::AxisEffect* effect = model::axis_effect(name);
    for (std::size_t k = 0; effect != nullptr && k < effect->numbers.size(); ++k) {
      if (effect->numbers[k].parameter == parameter) {
        return &effect->numbers[k];
      }
    }
  }
  return nullptr;
}

/// Writes a number, limited to the range of the file. @returns a sentence if it was limited; empty otherwise.
std::string put_number(const NamedValue& parameter, const model::AxisNumber& row, AxisUnit unit,
                       const std::string& of_axis, StickAxis& axis) {
  const model::Bounds range = row.file.range[static_cast<std::size_t>(unit)];
  const bool is_scale = row.member == &StickAxis::scale_per_count;
  const double wanted = is_scale ? std::abs(parameter.value) : parameter.value;
  const double written = std::clamp(wanted, range.low, range.high);
  axis.*row.member = written;
  return written == wanted ? ""
                           : "the vehicle file cannot hold " + parameter.name + " = " + std::to_string(wanted) +
                                 " of axis " + of_axis + "; it was limited to " + std::to_string(written);
}

// The axis starts empty: an effect that was not found is not in the file.
std::vector<std::string> put(const IdentifyResult& result, AxisUnit unit, model::Vehicle& vehicle, StickAxis& axis) {
  std::vector<std::string> not_in_file;
  axis = StickAxis{};
  for (const NamedValue& parameter : result.final_model.parameters) {
    const model::AxisNumber* row = row_of(result.final_model, parameter.name);
    if (row != nullptr && row->member == &StickAxis::tilt_limit) {
      vehicle.translation.tilt_limit_rad = std::clamp(parameter.value, 0.05, 0.7);  // of both axes together
    } else if (row != nullptr && row->member == &StickAxis::other_scale_per_count) {
      continue;  // belongs to the other axis, which has its own section
    } else if (row == nullptr || !row->file.exists(unit)) {
      not_in_file.push_back("the vehicle file has no place for " + parameter.name + " of axis " + result.axis);
    } else if (std::string said = put_number(parameter, *row, unit, result.axis, axis); !said.empty()) {
      not_in_file.push_back(std::move(said));
    }
  }
  if (result.final_model.dead_zone_shape == "jump") {
    axis.dead_zone_shape = model::DeadZoneShape::kJump;
  }
  return not_in_file;
}

// An effect that was not found is removed; mass and tilt limit were not identified and stay.
std::vector<std::string> put_translation(const IdentifyResult& result, model::Translation& translation) {
  std::vector<std::string> not_in_file;
  for (const auto& number : model::kEffectNumbers) {
    translation.*number.member = number.neutral;
  }
  std::size_t at = 0;
  for (const std::string& name : result.final_model.structure) {
    const model::TranslationEffect* effect = model::translation_effect(name);
    if (effect == nullptr) {
      continue;  // rigid_body
    }
    for (std::size_t k = 0; effect->has_key() && k < effect->parameter_count(); ++k) {
      const model::EffectParameter& parameter = effect->parameters[k];
      const double value = result.final_model.parameters[at + k].value;
      translation = translation.with(parameter.key, std::clamp(value, parameter.low, parameter.high));
    }
    if (!effect->has_key()) {
      not_in_file.push_back(name + " " + std::string(effect->not_in_file));
    }
    at += effect->parameter_count();
  }
  return not_in_file;
}

const Interval* interval_of(const IdentifyResult& result, const std::string& name) {
  for (const NamedInterval& one : result.final_intervals) {
    if (one.name == name) {
      return &one.interval;
    }
  }
  return nullptr;
}

bool outside(double believed, const Interval& found) { return believed < found.low || believed > found.high; }

std::vector<Refitted> refitted_axis(const StickAxis& believed, AxisUnit unit, const IdentifyResult& result) {
  std::vector<Refitted> out;
  for (const NamedValue& parameter : result.final_model.parameters) {
    const model::AxisNumber* row = row_of(result.final_model, parameter.name);
    const Interval* found = interval_of(result, parameter.name);
    if (row == nullptr || found == nullptr || !row->file.exists(unit)) {
      continue;
    }
    const double value = believed.*row->member;
    const bool is_scale = row->member == &StickAxis::scale_per_count;  // its sign is the column map's
    Interval size = *found;
    if (is_scale && size.value < 0.0) {
      size = {-found->value, -found->high, -found->low};
    }
    const double distance = row->logarithmic && value > 0.0 && size.value > 0.0 ? std::abs(std::log(size.value / value))
                                                                                : std::abs(size.value - value);
    const std::string key(row->file.key[static_cast<std::size_t>(unit)]);
    out.push_back({key, value, size, outside(value, size) && distance > row->min_relevant});
  }
  return out;
}

std::vector<Refitted> refitted_translation(const model::Translation& believed, const IdentifyResult& result) {
  std::vector<Refitted> out;
  std::size_t at = 0;
  for (const std::string& name : result.final_model.structure) {
    const model::TranslationEffect* effect = model::translation_effect(name);
    if (effect == nullptr) {
      continue;  // rigid_body
    }
    for (std::size_t k = 0; effect->has_key() && k < effect->parameter_count(); ++k) {
      if (at + k >= result.final_intervals.size()) {
        break;
      }
      const double value = model::number_of(believed, effect->parameters[k].key);
      const Interval& found = result.final_intervals[at + k].interval;
      const bool far = std::abs(found.value - value) > effect->min_relevant;
      out.push_back({std::string(effect->parameters[k].key), value, found, outside(value, found) && far});
    }
    at += effect->parameter_count();
  }
  return out;
}

}  // namespace

std::vector<Refitted> refitted(const model::Vehicle& believed, const IdentifyResult& result) {
  if (result.axis == "translation") {
    return refitted_translation(believed.translation, result);
  }
  return result.axis == "roll"    ? refitted_axis(believed.roll, AxisUnit::kTilt_rad, result)
         : result.axis == "pitch" ? refitted_axis(believed.pitch, AxisUnit::kTilt_rad, result)
         : result.axis == "climb" ? refitted_axis(believed.climb, AxisUnit::kClimb_m_s, result)
                                  : refitted_axis(believed.yaw_rate, AxisUnit::kYawRate_rad_s, result);
}

std::vector<std::string> put_axis(const IdentifyResult& result, model::Vehicle& vehicle) {
  if (result.axis == "translation") {
    return put_translation(result, vehicle.translation);
  }
  if (result.axis == "roll" || result.axis == "pitch") {  // axes, weights and noises were searched together
    vehicle.design = vehicle.robust = {};
  }
  return result.axis == "roll"    ? put(result, AxisUnit::kTilt_rad, vehicle, vehicle.roll)
         : result.axis == "pitch" ? put(result, AxisUnit::kTilt_rad, vehicle, vehicle.pitch)
         : result.axis == "climb" ? put(result, AxisUnit::kClimb_m_s, vehicle, vehicle.climb)
                                  : put(result, AxisUnit::kYawRate_rad_s, vehicle, vehicle.yaw_rate);
}

std::vector<std::string> update_vehicle_file(const std::string& path, const IdentifyResult& result,
                                             const std::string& source) {
  companion::VehicleFile file;
  if (std::filesystem::exists(path)) {
    file = companion::load_vehicle(path);
  }
  std::vector<std::string> not_in_file = put_axis(result, file.vehicle);
  file.sources[(result.axis == "translation" ? "" : "axis.") + result.axis] = source;
  file.intervals.erase("axis." + result.axis);
  std::erase_if(file.rivals, [&](const companion::Rival& rival) { return rival.axis == result.axis; });
  companion::save_vehicle(path, file);
  return not_in_file;
}

}  // namespace m100::lab::identify
