// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/vrc/stick_map.h"

#include "firmware/core/maths.h"
#include "firmware/model/stick_axis.h"

namespace m100::vrc {
namespace {

constexpr auto kLow_vrc = static_cast<float>(kStickLow);
constexpr auto kHigh_vrc = static_cast<float>(kStickHigh);
constexpr float kTravel_vrc = (kHigh_vrc - kLow_vrc) / 2.F;

float curved(float u, float exponent) {
  if (exponent == 1.F || u == 0.F) {
    return u;
  }
  const float size = u < 0.F ? -u : u;
  const float value = kTravel_vrc * model::power(size / kTravel_vrc, exponent);
  return u < 0.F ? -value : value;
}

float floored(float value) {
  const auto whole = static_cast<float>(static_cast<int>(value));
  return value < whole ? whole - 1.F : whole;
}

float side(float asymmetry, bool positive) { return 2.F * (positive ? asymmetry : 1.F) / (1.F + asymmetry); }

}  // namespace

core::Expected<Stick> StickMap::to_stick(float command_si) const {
  if (!(command_si - command_si == 0.F)) {
    return core::Status::kOutOfRange;
  }
  const float wanted = core::clamp(sign * command_si / scale_si_per_vrc, -4.F * kTravel_vrc, 4.F * kTravel_vrc);
  const float offset_vrc = curved(wanted / side(gain_asymmetry, wanted > 0.F), 1.F / exponent);
  float counts = neutral_vrc + offset_vrc;
  if (offset_vrc != 0.F && shape == model::DeadZoneShape::kContinuous) {
    counts += offset_vrc < 0.F ? -dead_zone_vrc : dead_zone_vrc;
  } else if (offset_vrc != 0.F && dead_zone_vrc > 0.F) {
    // The first whole counts outside of the dead zone, whose edge itself does nothing.
    const float below = -floored(dead_zone_vrc - neutral_vrc) - 1.F;
    const float above = floored(neutral_vrc + dead_zone_vrc) + 1.F;
    counts = offset_vrc < 0.F ? core::clamp(counts, kLow_vrc, below) : core::clamp(counts, above, kHigh_vrc);
  }
  return Stick{static_cast<std::uint16_t>(core::clamp(counts, kLow_vrc, kHigh_vrc) + 0.5F)};
}

float StickMap::to_command(Stick stick) const {
  const float offset_vrc = static_cast<float>(static_cast<std::uint16_t>(stick)) - neutral_vrc;
  const float size_vrc = offset_vrc < 0.F ? -offset_vrc : offset_vrc;
  if (size_vrc <= dead_zone_vrc) {
    return 0.F;
  }
  const float beyond_vrc = shape == model::DeadZoneShape::kContinuous ? size_vrc - dead_zone_vrc : size_vrc;
  const float bent = curved(offset_vrc < 0.F ? -beyond_vrc : beyond_vrc, exponent);
  return sign * scale_si_per_vrc * side(gain_asymmetry, offset_vrc > 0.F) * bent;
}

}  // namespace m100::vrc
