// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/output/vehicle_update.h"

#include <gtest/gtest.h>

namespace m100::lab::identify {
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

// A declared dead zone is not an accepted effect; its shape must reach the vehicle file all the same.
TEST(ToVehicle, CarriesTheShapeOfADeclaredDeadZone) {
  model::Vehicle vehicle;
  EXPECT_TRUE(put_axis(second_order_with_dead_zone("jump"), vehicle).empty());
  EXPECT_EQ(vehicle.pitch.dead_zone_shape, model::DeadZoneShape::kJump);
  EXPECT_DOUBLE_EQ(vehicle.pitch.dead_zone_counts, 25.0);
  EXPECT_TRUE(put_axis(second_order_with_dead_zone("continuous"), vehicle).empty());
  EXPECT_EQ(vehicle.pitch.dead_zone_shape, model::DeadZoneShape::kContinuous);
}

// Catches a translation result that is written into the yaw axis, and a wind that is stored as a property of the
// vehicle.
TEST(ToVehicle, TranslationGoesIntoItsOwnSection) {
  model::Vehicle vehicle;
  vehicle.yaw_rate.scale_per_count = 2e-3;
  vehicle.yaw_rate.time_constant_s = 0.2;
  vehicle.translation.mass_kg = 3.1;
  IdentifyResult result;
  result.axis = "translation";
  result.final_model.structure = {"rigid_body", "steady_wind", "linear_drag", "tilt_gain"};
  result.final_model.parameters = {{"accel_x_m_s2", 0.4}, {"accel_y_m_s2", -0.2}, {"rate_per_s", 0.31}, {"gain", 0.93}};
  const std::vector<std::string> not_in_file = put_axis(result, vehicle);
  EXPECT_DOUBLE_EQ(vehicle.translation.linear_drag_per_s, 0.31);
  EXPECT_DOUBLE_EQ(vehicle.translation.tilt_gain, 0.93);
  EXPECT_DOUBLE_EQ(vehicle.translation.mass_kg, 3.1);
  EXPECT_DOUBLE_EQ(vehicle.yaw_rate.time_constant_s, 0.2);
  ASSERT_EQ(not_in_file.size(), 1U);
  EXPECT_NE(not_in_file.front().find("steady_wind"), std::string::npos);
}

// Catches a lead zero of the climb axis that is found but not stored.
TEST(ToVehicle, ClimbCarriesEveryEffectThatCanBeFoundThere) {
  model::Vehicle vehicle;
  IdentifyResult result;
  result.axis = "climb";
  result.final_model.structure = {"second_order", "lead_zero", "backlash", "gain_drift"};
  result.final_model.parameters = {
      {"gain", 2.6e-3},  {"natural_frequency_rad_s", 5.0}, {"damping_ratio", 0.7},       {"zero_s", 0.1},
      {"delay_s", 0.05}, {"half_width_counts", 9.0},       {"fraction_per_minute", -0.1}};
  EXPECT_TRUE(put_axis(result, vehicle).empty());
  EXPECT_DOUBLE_EQ(vehicle.climb.lead_zero_s, 0.1);
  EXPECT_DOUBLE_EQ(vehicle.climb.backlash_counts, 9.0);
  EXPECT_DOUBLE_EQ(vehicle.climb.gain_drift_per_minute, -0.1);
}

}  // namespace
}  // namespace m100::lab::identify
