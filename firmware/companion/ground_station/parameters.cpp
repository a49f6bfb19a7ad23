// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/ground_station/parameters.h"

#include <algorithm>
#include <cstdint>

#include "firmware/core/time.h"

namespace m100::companion {
namespace {

using Source = const ParameterSource&;
constexpr std::uint8_t kReal32 = 9;  // MAV_PARAM_TYPE

// Wire names are upper case by custom, and end in their unit where there is room for it.
constexpr std::array kRows{
    ParameterEntry{"FENCE_X_LOW_M", "m", [](Source s) { return s.config.fence.side[0].low_m; }},
    ParameterEntry{"FENCE_X_HIGH_M", "m", [](Source s) { return s.config.fence.side[0].high_m; }},
    ParameterEntry{"FENCE_Y_LOW_M", "m", [](Source s) { return s.config.fence.side[1].low_m; }},
    ParameterEntry{"FENCE_Y_HIGH_M", "m", [](Source s) { return s.config.fence.side[1].high_m; }},
    ParameterEntry{"FENCE_Z_LOW_M", "m", [](Source s) { return s.config.fence.side[2].low_m; }},
    ParameterEntry{"FENCE_Z_HIGH_M", "m", [](Source s) { return s.config.fence.side[2].high_m; }},
    ParameterEntry{"WIND_CLASS_M_S", "m/s", [](Source s) { return s.config.fence.wind_m_s; }},
    ParameterEntry{"POSE_FRESH_S", "s", [](Source s) { return core::seconds<double>(s.config.limits.pose_fresh); }},
    ParameterEntry{"POSE_COAST_S", "s", [](Source s) { return core::seconds<double>(s.config.limits.coast); }},
    ParameterEntry{"POSE_LEVEL_S", "s", [](Source s) { return core::seconds<double>(s.config.limits.level); }},
    ParameterEntry{"GOAL_SPEED_M_S", "m/s", [](Source s) { return s.goals.speed_m_s; }},
    ParameterEntry{"GOAL_ACC_M_S2", "m/s^2", [](Source s) { return s.goals.acceleration_m_s2; }},
    ParameterEntry{"GOAL_YAW_RAD_S", "rad/s", [](Source s) { return s.goals.yaw_rate_rad_s; }},
    ParameterEntry{"ROLL_SCALE", "rad/count", [](Source s) { return s.vehicle.roll.scale_per_count; }},
    ParameterEntry{"ROLL_W_RAD_S", "rad/s", [](Source s) { return s.vehicle.roll.natural_frequency_rad_s; }},
    ParameterEntry{"ROLL_DAMPING", "-", [](Source s) { return s.vehicle.roll.damping_ratio; }},
    ParameterEntry{"ROLL_DELAY_S", "s", [](Source s) { return s.vehicle.roll.transport_delay_s; }},
    ParameterEntry{"ROLL_DEAD_CNT", "counts", [](Source s) { return s.vehicle.roll.dead_zone_counts; }},
    ParameterEntry{"ROLL_TRIM_CNT", "counts", [](Source s) { return s.vehicle.roll.trim_counts; }},
    ParameterEntry{"PITCH_SCALE", "rad/count", [](Source s) { return s.vehicle.pitch.scale_per_count; }},
    ParameterEntry{"PITCH_W_RAD_S", "rad/s", [](Source s) { return s.vehicle.pitch.natural_frequency_rad_s; }},
    ParameterEntry{"PITCH_DAMPING", "-", [](Source s) { return s.vehicle.pitch.damping_ratio; }},
    ParameterEntry{"PITCH_DELAY_S", "s", [](Source s) { return s.vehicle.pitch.transport_delay_s; }},
    ParameterEntry{"PITCH_DEAD_CNT", "counts", [](Source s) { return s.vehicle.pitch.dead_zone_counts; }},
    ParameterEntry{"PITCH_TRIM_CNT", "counts", [](Source s) { return s.vehicle.pitch.trim_counts; }},
    ParameterEntry{"YAW_SCALE", "(rad/s)/count", [](Source s) { return s.vehicle.yaw_rate.scale_per_count; }},
    ParameterEntry{"CLIMB_SCALE", "(m/s)/count", [](Source s) { return s.vehicle.climb.scale_per_count; }},
    ParameterEntry{"MASS_KG", "kg", [](Source s) { return s.vehicle.translation.mass_kg; }},
    ParameterEntry{"TILT_LIMIT_RAD", "rad", [](Source s) { return s.vehicle.translation.tilt_limit_rad; }},
};
static_assert(kRows.size() <= Parameters::kMaxParameters);
static_assert(std::ranges::all_of(kRows, [](const ParameterEntry& row) { return row.name.size() <= 16; }));

/// The name ends at its first zero, or is 16 characters long.
std::string_view name_in(const std::array<char, 16>& text) {
  return {text.data(), static_cast<std::size_t>(std::ranges::find(text, '\0') - text.begin())};
}

/// @returns the number of parameters if none has that name.
std::size_t index_of(const std::array<char, 16>& name) {
  return static_cast<std::size_t>(std::ranges::find(kRows, name_in(name), &ParameterEntry::name) - kRows.begin());
}

}  // namespace

std::string_view name_of(const mavlink::ParamSet& parameter) {
  const std::size_t index = index_of(parameter.param_id);
  return index < kRows.size() ? kRows[index].name : "of unknown name";
}

std::span<const ParameterEntry> parameter_entries() { return kRows; }

Parameters::Parameters(const ParameterSource& source) : next_(kRows.size()) {
  for (std::size_t i = 0; i < kRows.size(); ++i) {
    values_[i] = static_cast<float>(kRows[i].value(source));
  }
}

mavlink::ParamValue Parameters::message(std::size_t index) const {
  mavlink::ParamValue message{.param_value = values_[index],
                              .param_count = static_cast<std::uint16_t>(kRows.size()),
                              .param_index = static_cast<std::uint16_t>(index),
                              .param_id = {},
                              .param_type = kReal32};
  std::ranges::copy(kRows[index].name, message.param_id.begin());
  return message;
}

void Parameters::receive(const Request& request, Replies& replies) {
  if (std::holds_alternative<mavlink::ParamRequestList>(request.message)) {
    next_ = 0;
    return;
  }
  std::size_t index = kRows.size();
  if (const auto* const parameter = std::get_if<mavlink::ParamSet>(&request.message)) {
    index = index_of(parameter->param_id);
  } else if (const auto* const asked = std::get_if<mavlink::ParamRequestRead>(&request.message)) {
    index = asked->param_index < 0 ? index_of(asked->param_id) : static_cast<std::size_t>(asked->param_index);
  }
  if (index < kRows.size()) {  // otherwise there is no such parameter, for which MAVLink has no answer
    (void)replies.add(message(index));
  }
}

void Parameters::tick(Replies& replies) {
  if (next_ < kRows.size() && replies.add(message(next_))) {
    ++next_;
  }
}

}  // namespace m100::companion
