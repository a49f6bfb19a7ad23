// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/tools/identify/to_vehicle.h"

#include <gtest/gtest.h>

namespace m100::tools::identify {
namespace {

IdentifyResult second_order_with_dead_zone(const char* shape) {
  IdentifyResult result;
  result.axis = "pitch";
  result.final_model.structure = {"second_order", "dead_zone"};
  result.final_model.parameters = {
      {"gain", 9e-4}, {"natural_frequency_rad_s", 8.0}, {"damping_ratio", 0.7}, {"width_counts", 25.0}};
  result.final_model.dead_zone_shape = shape;
  return result;
}

// A dead zone that was declared beforehand is no accepted effect; its shape must reach the vehicle all the same.
TEST(ToVehicle, CarriesTheShapeOfADeclaredDeadZone) {
  model::Vehicle vehicle;
  EXPECT_TRUE(put_axis(second_order_with_dead_zone("jump"), vehicle).empty());
  EXPECT_EQ(vehicle.pitch.dead_zone_shape, model::DeadZoneShape::kJump);
  EXPECT_DOUBLE_EQ(vehicle.pitch.dead_zone_counts, 25.0);
  EXPECT_TRUE(put_axis(second_order_with_dead_zone("continuous"), vehicle).empty());
  EXPECT_EQ(vehicle.pitch.dead_zone_shape, model::DeadZoneShape::kContinuous);
}

}  // namespace
}  // namespace m100::tools::identify
