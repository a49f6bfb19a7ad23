// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "firmware/companion/files/vehicle_file.h"
#include "host_tests/lab/gains/enclosure.h"
#include "host_tests/lab/gains/flown_loop.h"
#include "host_tests/lab/gains/gain_tables.h"
#include "host_tests/lab/gains/margin_box.h"
#include "host_tests/lab/gains/plant_response.h"

namespace m100::lab::gains {
namespace {

constexpr const char* kVehicle = "firmware/mpc/generated/vehicle.toml";
constexpr const char* kNoZero = "host_tests/lab/gains/no_zero.toml";

/// Weights and noises of a robust design for the shipped vehicle file.
model::Vehicle robust_design() {
  model::Vehicle vehicle = companion::load_vehicle(kVehicle).vehicle;
  vehicle.design = {.roll = {},
                    .pitch = {},
                    .mpc = vehicle.mpc,
                    .estimator = vehicle.estimator,
                    .has_mpc = true,
                    .has_estimator = true};
  vehicle.design.mpc.velocity = 4.0;
  vehicle.design.mpc.input = 16.0;
  vehicle.design.mpc.input_rate = 3.0;
  vehicle.design.estimator.disturbance_process_m_s2 = 0.16;
  vehicle.design.estimator.input_offset_process_rad = 0.0015;
  vehicle.design.estimator.attitude_sigma_rad = 0.01;
  vehicle.design.estimator.rate_sigma_rad_s = 0.1;
  return vehicle;
}

std::vector<OpenStructure> both_structures() {
  std::vector<OpenStructure> out = open_structures(companion::load_vehicle(kVehicle));
  out.resize(1);
  out.push_back(open_structures(companion::load_vehicle(kNoZero)).front());
  return out;
}

// The controller's tables come from the design, and only they: the identified axes of the vehicle stay.
TEST(Design, ReplacesWhatTheControllerPredictsWith) {
  model::Vehicle vehicle = companion::load_vehicle(kVehicle).vehicle;
  vehicle.design = vehicle.robust = {};
  const double plain = make_gain_tables(vehicle).x.state_gain[0];
  vehicle.design.pitch = vehicle.pitch;
  vehicle.design.pitch.transport_delay_s += 0.03;
  const mpc::GainTables<double> tables = make_gain_tables(vehicle);
  EXPECT_EQ(tables.x.state_gain[0], plain);
  EXPECT_DOUBLE_EQ(tables.x.delay.delay_s, vehicle.pitch.transport_delay_s + 0.03);
  EXPECT_DOUBLE_EQ(tables.y.delay.delay_s, vehicle.roll.transport_delay_s);
  EXPECT_EQ(make_gain_tables(model::controller_model(vehicle)).x.delay.delay_s, tables.x.delay.delay_s);
}

// The closed form of the vehicle times the lifted controller is the loop that is stepped from tick to tick.
TEST(PlantResponse, TimesTheControllerIsTheLoopAsFlown) {
  for (const char* file : {kVehicle, kNoZero}) {
    const model::Vehicle truth = companion::load_vehicle(file).vehicle;
    const model::Vehicle believed = robust_design();
    for (const Axis axis : {Axis::kX, Axis::kY}) {
      for (const Way& way : {kVirtualRcWay, kMovementWay}) {
        const FlownController controller(believed, axis, way);
        const FlownLoop loop(controller, truth, axis, way);
        const LiftedController lifted(controller, way);
        const model::StickAxis& of = attitude_of(truth, axis);
        const int ticks = static_cast<int>(of.transport_delay_s / 0.01 + 1e-6);
        const PlantParameters<double> plant{.frequency_rad_s = of.natural_frequency_rad_s,
                                            .damping = of.damping_ratio,
                                            .rest_s = of.transport_delay_s - 0.01 * ticks,
                                            .lead_s = of.lead_zero_s,
                                            .drag_per_s = truth.translation.linear_drag_per_s,
                                            .pull_m_s2 = (axis == Axis::kX ? 1.0 : -1.0) * model::kGravity_m_s2,
                                            .delay_ticks = ticks};
        const double stick = way.by_sticks ? of.scale_per_count / controller.scale_per_count : 1.0;
        for (const double w : {0.3, 2.0, 7.0, 20.0, 60.0}) {
          const std::complex<double> z = std::polar(1.0, w * loop.period_s());
          std::vector<ComplexNumber<double>> response;
          plant_response<double>(plant, {z.real(), z.imag()}, way, static_cast<int>(way.pose_age_ticks), response);
          const Eigen::RowVectorXcd law = lifted.response(z);
          std::complex<double> sum = 0.0;
          for (Eigen::Index k = 0; k < law.size(); ++k) {
            const ComplexNumber<double>& y = response[static_cast<std::size_t>(k)];
            sum += stick * law(k) * std::complex<double>(y.re, y.im);
          }
          const std::complex<double> stepped = loop.response(w);
          EXPECT_LT(std::abs(sum - stepped), 1e-6 * std::abs(stepped)) << file << " " << w;
        }
      }
    }
  }
}

TEST(Enclosure, ContainsExactResultsAndTheirDerivatives) {
  std::mt19937 dice(3);
  const auto between = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(dice); };
  for (int i = 0; i < 2000; ++i) {
    const double low = between(0.1, 1.3), width = between(0.0, 0.1), at = low + width * between(0.0, 1.0);
    const auto x = EnclosedJet<1>::variable({low, low + width}, 0);
    const EnclosedJet<1> out = sin(x) * exp(x) / sqrt(x) - square(cos(x));
    const double value = std::sin(at) * std::exp(at) / std::sqrt(at) - std::cos(at) * std::cos(at);
    EXPECT_TRUE(out.value.contains(value)) << at;
    const double slope =
        std::exp(at) * ((std::cos(at) + std::sin(at)) / std::sqrt(at) - 0.5 * std::sin(at) / (at * std::sqrt(at))) +
        2.0 * std::sin(at) * std::cos(at);
    EXPECT_TRUE(out.by[0].contains(slope)) << at;
  }
}

TEST(MarginBox, FindsTheRobustDesignInsideAndTheFastOneOutside) {
  const MarginBox box(both_structures());
  const model::Vehicle robust = robust_design();
  const WorstMargins calm =
      box.worst(robust, MarginBox::Extent::kCorners, {.structure = {}, .axis = {}, .by_sticks = true});
  EXPECT_TRUE(calm.stable);
  EXPECT_NEAR(calm.peak_sensitivity, 2.14, 0.02) << "as an independent trial found";
  EXPECT_GE(calm.delay_margin_s, 0.08);
  model::Vehicle fast = robust;
  fast.design.mpc.velocity = 20.0;
  fast.design.mpc.input = 12.0;
  fast.design.mpc.input_rate = 0.3;
  fast.design.estimator.attitude_sigma_rad = 0.005;
  fast.design.estimator.rate_sigma_rad_s = 0.06;
  EXPECT_FALSE(box.worst(fast, MarginBox::Extent::kCorners).stable) << "unstable in a corner on movement control";
}

}  // namespace
}  // namespace m100::lab::gains
