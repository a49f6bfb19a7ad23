// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/loop/world_numbers.h"

#include "firmware/companion/files/vehicle_keys.h"

namespace m100::lab::loop {
namespace {

Json axis_numbers(const model::StickAxis& world, const model::StickAxis& vehicle, model::AxisUnit unit) {
  const model::StickAxis neutral;
  Json out = Json::object();
  for (const companion::NumberKey<model::StickAxis>& key : companion::axis_keys(unit)) {
    const double in_world = world.*key.member;
    const double in_file = vehicle.*key.member;
    const double without = neutral.*key.member;
    if (in_world != without || in_file != without) {
      out[std::string(key.key)] = {{"world", in_world}, {"vehicle", in_file}, {"without", without}};
    }
  }
  return out;
}

}  // namespace

Json world_numbers(const sim::Plant& world, const model::Vehicle& vehicle) {
  return {{"roll", axis_numbers(world.roll, vehicle.roll, model::AxisUnit::kTilt_rad)},
          {"pitch", axis_numbers(world.pitch, vehicle.pitch, model::AxisUnit::kTilt_rad)},
          {"yaw_rate", axis_numbers(world.yaw_rate, vehicle.yaw_rate, model::AxisUnit::kYawRate_rad_s)},
          {"climb", axis_numbers(world.climb, vehicle.climb, model::AxisUnit::kClimb_m_s)}};
}

}  // namespace m100::lab::loop
