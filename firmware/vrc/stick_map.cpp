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
  const float size = core::abs(u);
  const float value = kTravel_vrc * model::power(size / kTravel_vrc, exponent);
  return u < 0.F ? -value : value;
}

float ceiling(float value) {
  const auto whole = static_cast<float>(static_cast<int>(value));
  return value > whole ? whole + 1.F : whole;
}

float side(float asymmetry, bool positive) { return 2.F * (positive ? asymmetry : 1.F) / (1.F + asymmetry); }

}  // namespace

core::Expected<Stick> StickMap::to_stick(float command_si) const {
  if (!(command_si - command_si == 0.F)) {
    return core::Status::kOutOfRange;
  }
  const float wanted = core::clamp(sign * command_si / scale_si_per_vrc, -4.F * kTravel_vrc, 4.F * kTravel_vrc);
  float offset_vrc = curved(wanted / side(gain_asymmetry, wanted > 0.F), 1.F / exponent);
  const float size_vrc = core::abs(offset_vrc);
  if (offset_vrc != 0.F) {
    float pushed_vrc = size_vrc;
    if (shape == model::DeadZoneShape::kContinuous) {
      pushed_vrc = size_vrc + dead_zone_vrc;
    } else if (size_vrc < dead_zone_vrc) {
      pushed_vrc = ceiling(dead_zone_vrc);
    }
    offset_vrc = offset_vrc < 0.F ? -pushed_vrc : pushed_vrc;
  }
  const float counts = core::clamp(neutral_vrc + offset_vrc, kLow_vrc, kHigh_vrc);
  return Stick{static_cast<std::uint16_t>(counts + 0.5F)};
}

float StickMap::to_command(Stick stick) const {
  const float offset_vrc = static_cast<float>(static_cast<std::uint16_t>(stick)) - neutral_vrc;
  const float size_vrc = core::abs(offset_vrc);
  if (size_vrc <= dead_zone_vrc) {
    return 0.F;
  }
  const float beyond_vrc = shape == model::DeadZoneShape::kContinuous ? size_vrc - dead_zone_vrc : size_vrc;
  const float bent = curved(offset_vrc < 0.F ? -beyond_vrc : beyond_vrc, exponent);
  return sign * scale_si_per_vrc * side(gain_asymmetry, offset_vrc > 0.F) * bent;
}

}  // namespace m100::vrc
