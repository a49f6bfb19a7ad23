// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/vrc/command_map.h"

#include "firmware/core/assert.h"
#include "firmware/core/maths.h"

namespace m100::vrc {
namespace {

bool finite(float value) { return value - value == 0.F; }

bool finite(const ctl::Command<float>& command) {
  return finite(command.roll_rad) && finite(command.pitch_rad) && finite(command.climb_m_s) &&
         finite(command.yaw_rate_rad_s);
}

StickMap map_of(const model::StickAxis& axis, float sign = 1.F) {
  return {.scale_si_per_vrc = static_cast<float>(axis.scale_per_count),
          .neutral_vrc = static_cast<float>(1024.0 + axis.trim_counts),
          .dead_zone_vrc = static_cast<float>(axis.dead_zone_counts),
          .shape = axis.dead_zone_shape,
          .exponent = static_cast<float>(axis.stick_exponent),
          .gain_asymmetry = static_cast<float>(axis.gain_asymmetry),
          .sign = sign};
}

/// Whether divisors and exponents are valid for to_stick(); checked() ensures the scale. The vehicle file's ranges
/// ensure this (files/vehicle_file.h); a vehicle that is constructed by hand must meet it, too.
bool is_usable(const StickMap& map) {
  return map.dead_zone_vrc >= 0.F && map.exponent > 0.F && map.gain_asymmetry > 0.F && finite(map.neutral_vrc);
}

/// An axis that was not identified (scale 0) still needs a divisor: one of the order of magnitude of the paper's scale.
StickMap checked(StickMap map, float fallback_scale) {
  if (!(map.scale_si_per_vrc > 0.F)) {
    map.scale_si_per_vrc = fallback_scale;
  }
  return map;
}

}  // namespace

CommandMap::CommandMap(const model::Vehicle& vehicle, StickRule rule)
    : maps_{checked(map_of(vehicle.roll), 8.65e-4F), checked(map_of(vehicle.pitch), 8.44e-4F),
            checked(map_of(vehicle.climb), 2.65e-3F), checked(map_of(vehicle.yaw_rate, -1.F), 2.24e-3F)},
      rule_(rule) {
  for (const StickMap& map : maps_) {
    M100_ASSERT(is_usable(map));
  }
  trims_vrc_ = {maps_[kRoll].neutral_vrc, maps_[kPitch].neutral_vrc};
}

Stick CommandMap::modulated(StickIndex index, float command_si) {
  const StickMap& map = maps_[index];
  if (rule_ == StickRule::kAsThePaper) {
    return map.to_stick(command_si).value();
  }
  const float wanted_si = command_si + remainder_[index];
  const auto error = [&](Stick stick) {
    const float e = wanted_si - map.to_command(stick);
    return e < 0.F ? -e : e;
  };
  const Stick neutral = map.to_stick(0.F).value();
  Stick stick = map.to_stick(wanted_si).value();
  if (error(neutral) <= error(stick)) {  // in a dead zone with a jump, nearer to its middle than to its edge
    stick = neutral;
  }
  const float most_si = map.scale_si_per_vrc * (map.dead_zone_vrc + 1.F);
  remainder_[index] = core::clamp(wanted_si - map.to_command(stick), -most_si, most_si);
  return stick;
}

core::Expected<Sticks> CommandMap::to_sticks(const ctl::Command<float>& command) {
  if (!finite(command)) {
    return core::Status::kOutOfRange;
  }
  return Sticks{.roll = modulated(kRoll, command.roll_rad),
                .pitch = modulated(kPitch, command.pitch_rad),
                .throttle = modulated(kThrottle, command.climb_m_s),
                .yaw = modulated(kYaw, command.yaw_rate_rad_s)};
}

ctl::Command<float> CommandMap::to_command(const Sticks& sticks) const {
  return {.roll_rad = maps_[kRoll].to_command(sticks.roll),
          .pitch_rad = maps_[kPitch].to_command(sticks.pitch),
          .climb_m_s = maps_[kThrottle].to_command(sticks.throttle),
          .yaw_rate_rad_s = maps_[kYaw].to_command(sticks.yaw)};
}

Sticks CommandMap::neutral() const {
  return {.roll = maps_[kRoll].to_stick(0.F).value(),
          .pitch = maps_[kPitch].to_stick(0.F).value(),
          .throttle = maps_[kThrottle].to_stick(0.F).value(),
          .yaw = maps_[kYaw].to_stick(0.F).value()};
}

}  // namespace m100::vrc
