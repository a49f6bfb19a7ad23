// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/gains/write_tables.h"

namespace m100::lab::gains {
namespace {

// Catches a table that was edited by hand, or not regenerated after a change of the vehicle or of the generator.
TEST(GeneratedTable, IsWhatTheVehicleFileGives) {
  const companion::VehicleFile file = companion::load_vehicle("firmware/mpc/generated/vehicle.toml");
  std::ifstream stream("firmware/mpc/generated/gain_table.h");
  const std::string there((std::istreambuf_iterator<char>(stream)), {});
  EXPECT_TRUE(there == to_header(make_table_set(file), file.vehicle))
      << "run: m100-lab gains --vehicle firmware/mpc/generated/vehicle.toml --out firmware/mpc/generated/gain_table.h";
  EXPECT_EQ(mpc::generated::kVehicleDigest, file.digest);
}

// Catches a field of the vehicle file that the generated vehicle lacks.
TEST(GeneratedTable, CarriesTheWholeVehicle) {
  const companion::VehicleFile file = companion::load_vehicle("firmware/mpc/generated/vehicle.toml");
  EXPECT_EQ(companion::to_text(mpc::generated::kVehicle, {}), companion::to_text(file.vehicle, {}));
}

// The inputs of the quadratic program are slopes. A limit that uses the angle as a slope would end at 23.6 degrees.
TEST(GeneratedTable, EndsAtTheTiltLimitInDegrees) {
  const double limit_rad = mpc::generated::kVehicle.translation.tilt_limit_rad;
  for (const mpc::GainTable<double>* table : {&mpc::generated::kX<double>, &mpc::generated::kY<double>}) {
    EXPECT_NEAR(std::atan(table->input_max_slope), limit_rad, 1e-15);
    EXPECT_NEAR(std::atan(table->input_min_slope), -limit_rad, 1e-15);
  }
}

TEST(GeneratedTable, InFloatIsTheDoubleRounded) {
  const mpc::GainTable<float>& single = mpc::generated::kX<float>;
  const mpc::GainTable<double>& twice = mpc::generated::kX<double>;
  for (std::size_t i = 0; i < single.hessian.size(); ++i) {
    EXPECT_EQ(single.hessian.at(i), static_cast<float>(twice.hessian.at(i)));
  }
  EXPECT_EQ(single.setpoint.laws.size(), twice.setpoint.laws.size());
}

}  // namespace
}  // namespace m100::lab::gains
