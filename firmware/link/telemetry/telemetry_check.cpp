// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/telemetry/telemetry_check.h"

#include <array>
#include <cmath>

namespace m100::link {
namespace {

template <std::size_t kCount>
bool finite(const std::array<float, kCount>& values) {
  for (const float value : values) {
    if (!std::isfinite(value)) {
      return false;
    }
  }
  return true;
}

bool finite(const protocol::Telemetry::Position& position) {
  return std::isfinite(position.latitude_rad) && std::isfinite(position.longitude_rad) &&
         std::isfinite(position.altitude_m) && std::isfinite(position.height_m);
}

}  // namespace

std::uint32_t reject_non_finite(protocol::Telemetry& telemetry, const protocol::Telemetry& former) {
  using protocol::Telemetry;
  using Item = protocol::TelemetryItem;
  std::uint32_t refused = 0;
  const auto check = [&](Item item, auto member) {
    if (telemetry.has(item) && !finite(telemetry.*member)) {
      telemetry.*member = former.*member;
      telemetry.items = static_cast<std::uint16_t>(telemetry.items & ~static_cast<std::uint16_t>(item));
      ++refused;
    }
  };
  check(Item::kAttitude, &Telemetry::attitude);
  check(Item::kAcceleration, &Telemetry::acceleration);
  check(Item::kVelocity, &Telemetry::velocity_ned_m_s);
  check(Item::kAngularVelocity, &Telemetry::angular_velocity_frd_rad_s);
  check(Item::kPosition, &Telemetry::position);
  return refused;
}

}  // namespace m100::link
