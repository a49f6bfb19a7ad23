// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/telemetry/telemetry_check.h"

#include <array>
#include <bit>
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

std::uint16_t not_finite_items(const protocol::Telemetry& telemetry) {
  using Item = protocol::TelemetryItem;
  std::uint16_t bad = 0;
  const auto judge = [&](Item item, bool good) {
    if (telemetry.has(item) && !good) {
      bad = static_cast<std::uint16_t>(bad | static_cast<std::uint16_t>(item));
    }
  };
  const protocol::Telemetry::Position& position = telemetry.position;
  judge(Item::kAttitude, finite(telemetry.attitude));
  judge(Item::kAcceleration, finite(telemetry.acceleration));
  judge(Item::kVelocity, finite(telemetry.velocity_ned_m_s));
  judge(Item::kAngularVelocity, finite(telemetry.angular_velocity_frd_rad_s));
  judge(Item::kPosition, std::isfinite(position.latitude_rad) && std::isfinite(position.longitude_rad) &&
                             std::isfinite(position.altitude_m) && std::isfinite(position.height_m));
  return bad;
}

/// Restores the former values of the items in `keep`.
void restore(protocol::Telemetry& telemetry, const protocol::Telemetry& former, std::uint16_t keep) {
  using Item = protocol::TelemetryItem;
  const auto kept = [&](Item item) { return (keep & static_cast<std::uint16_t>(item)) != 0; };
  if (kept(Item::kAttitude)) {
    telemetry.attitude = former.attitude;
  }
  if (kept(Item::kAcceleration)) {
    telemetry.acceleration = former.acceleration;
  }
  if (kept(Item::kVelocity)) {
    telemetry.velocity_ned_m_s = former.velocity_ned_m_s;
  }
  if (kept(Item::kAngularVelocity)) {
    telemetry.angular_velocity_frd_rad_s = former.angular_velocity_frd_rad_s;
  }
  if (kept(Item::kPosition)) {
    telemetry.position = former.position;
  }
  telemetry.items = static_cast<std::uint16_t>(telemetry.items & ~keep);
}

}  // namespace

std::uint32_t reject_non_finite(protocol::Telemetry& telemetry, const protocol::Telemetry& former) {
  const std::uint16_t bad = not_finite_items(telemetry);
  restore(telemetry, former, bad);
  return static_cast<std::uint32_t>(std::popcount(bad));
}

}  // namespace m100::link
