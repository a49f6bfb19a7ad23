// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "firmware/companion/files/vehicle_file.h"
#include "host_tests/lab/gains/certificate/certify.h"
#include "host_tests/lab/gains/certificate/enclosed_loop.h"
#include "host_tests/lab/gains/certificate/enclosure.h"
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

/// The closed form of the vehicle times the lifted controller, at z on the unit circle.
/// @param stick the true effect of a count over the believed one.
std::complex<double> loop_response(const model::Vehicle& truth, Axis axis, const LoopTiming& timing, double stick,
                                   const LiftedController& lifted, std::complex<double> z) {
  const model::StickAxis& of = attitude_of(truth, axis);
  const int ticks = static_cast<int>(of.transport_delay_s / 0.01 + 1e-6);
  const PlantParameters<double> plant{.frequency_rad_s = of.natural_frequency_rad_s,
                                      .damping = of.damping_ratio,
                                      .rest_s = of.transport_delay_s - 0.01 * ticks,
                                      .lead_s = of.lead_zero_s,
                                      .drag_per_s = truth.translation.linear_drag_per_s,
                                      .pull_m_s2 = (axis == Axis::kX ? 1.0 : -1.0) * model::kGravity_m_s2,
                                      .delay_ticks = ticks};
  std::vector<ComplexNumber<double>> response;
  const ComplexNumber<double> integrators =
      plant_response<double>(plant, {z.real(), z.imag()}, timing, static_cast<int>(timing.pose_age_ticks), response);
  const Eigen::RowVectorXcd law = lifted.response(z);
  std::complex<double> sum = 0.0;
  for (Eigen::Index k = 0; k < law.size(); ++k) {
    const ComplexNumber<double>& number = response[static_cast<std::size_t>(k)];
    const std::complex<double> y(number.re, number.im);
    sum += stick * law(k) * (k % 3 == 0 ? y / std::complex<double>(integrators.re, integrators.im) : y);
  }
  return sum;
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
      for (const LoopTiming& timing : {kVirtualRcTiming, kMovementTiming}) {
        const FlownController controller(believed, axis, timing);
        const FlownLoop loop(controller, truth, axis, timing);
        const LiftedController lifted(controller, timing);
        const double stick =
            timing.by_sticks ? attitude_of(truth, axis).scale_per_count / controller.scale_per_count : 1.0;
        for (const double w : {0.3, 2.0, 7.0, 20.0, 60.0}) {
          const std::complex<double> z = std::polar(1.0, w * loop.period_s());
          const std::complex<double> closed_form = loop_response(truth, axis, timing, stick, lifted, z);
          const std::complex<double> stepped = loop.response(w);
          EXPECT_LT(std::abs(closed_form - stepped), 1e-6 * std::abs(stepped)) << file << " " << w;
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
    EXPECT_TRUE(out.by[0].contains(0.5 * width * slope)) << at;
  }
}

TEST(ControllerPolynomials, ContainTheResponseOverAnArc) {
  for (const LoopTiming& timing : {kVirtualRcTiming, kMovementTiming}) {
    const LiftedController lifted(FlownController(robust_design(), Axis::kX, timing), timing);
    const ControllerPolynomials polynomials(lifted);
    for (const double low : {0.004, 0.05, 0.4, 2.0, 3.0}) {
      const double width = 0.02 * low;
      const ControllerPolynomials::OverArc arc = polynomials.over({low, low + width});
      ASSERT_TRUE(arc.valid);
      const Eigen::RowVectorXcd from = lifted.response(std::polar(1.0, low));
      const Eigen::RowVectorXcd to = lifted.response(std::polar(1.0, low + width));
      for (Eigen::Index k = 0; k < from.size(); ++k) {
        const ComplexNumber<LoopJet>& law = arc.response[static_cast<std::size_t>(k)];
        const std::complex<double> slope = 0.5 * (to(k) - from(k));  // a mean of the derivatives of each part
        const double slack = 1e-7 * (std::abs(from(k)) + std::abs(slope));
        EXPECT_NEAR(std::clamp(from(k).real(), law.re.value.low, law.re.value.high), from(k).real(), slack);
        EXPECT_NEAR(std::clamp(to(k).imag(), law.im.value.low, law.im.value.high), to(k).imag(), slack);
        const Enclosure &re = law.re.by[kAngleVariable], &im = law.im.by[kAngleVariable];
        EXPECT_NEAR(std::clamp(slope.real(), re.low, re.high), slope.real(), slack) << low << " " << k;
        EXPECT_NEAR(std::clamp(slope.imag(), im.low, im.high), slope.imag(), slack) << low << " " << k;
        EXPECT_LT(law.re.value.high - law.re.value.low, 0.5 * std::abs(from(k)) + 1e-3) << "tight enough to be of use";
      }
    }
  }
}

// Everywhere in a cell the loop that is stepped from tick to tick lies within the linear form and its remainder.
TEST(EnclosedLoop, ContainsTheLoopAsFlown) {
  const OpenStructure structure = both_structures().front();
  std::mt19937 dice(5);
  for (const LoopTiming& timing : {kVirtualRcTiming, kMovementTiming}) {
    const FlownController controller(robust_design(), Axis::kX, timing);
    EnclosedLoop enclosed(robust_design(), structure, Axis::kX, timing);
    const double period_s = 0.01 * static_cast<double>(timing.command_ticks);
    for (const double w : {1.0, 6.0, 15.0}) {
      const LoopCell cell{{Range{6.0, 6.01}, {0.70, 0.701}, {0.0045, 0.0046}, {w * period_s, 1.001 * w * period_s}}};
      const EnclosedLoop::Linear loop = enclosed.over(cell, 5);
      ASSERT_TRUE(loop.valid);
      EXPECT_LT(loop.rest, 0.1 * std::hypot(loop.middle.re.middle(), loop.middle.im.middle()));
      for (int i = 0; i < 10; ++i) {
        std::array<double, 4> at{};
        std::complex<double> expected(loop.middle.re.middle(), loop.middle.im.middle());
        for (std::size_t k = 0; k < 4; ++k) {
          at[k] = std::uniform_real_distribution<double>(cell.range[k].low, cell.range[k].high)(dice);
          expected += loop.slope[k] * (at[k] - cell.middle(k)) / cell.half(k);
        }
        model::Vehicle truth = structure.vehicle;
        truth.pitch.natural_frequency_rad_s = at[0];
        truth.pitch.damping_ratio = at[1];
        truth.pitch.transport_delay_s = 0.05 + at[2];
        const std::complex<double> flown =
            -FlownLoop(controller, truth, Axis::kX, timing).response(at[kAngleVariable] / period_s);
        EXPECT_LE(std::abs(flown - expected), loop.rest + 1e-6 * std::abs(flown)) << w;
      }
    }
  }
}

TEST(Certify, ProvesASmallBoxAndRefusesAnUnstableLoop) {
  std::vector<OpenStructure> structures = both_structures();
  structures.resize(1);
  for (AxisBox& box : structures[0].box) {
    const double delay_s = 0.055, damping = 0.72;
    box = {.gain = {0.97, 1.03},
           .frequency = {0.9995, 1.0005},
           .damping = {damping, damping + 0.001},
           .delay_s = {delay_s, delay_s + 0.0001}};
  }
  for (const CertifiedLoop& one : certify(robust_design(), structures, 1.13, [](const CertifiedLoop&) {})) {
    EXPECT_TRUE(one.holds) << one.why_not;
    EXPECT_GE(one.bound, 1.0);
    EXPECT_LE(one.bound, 1.15 * one.sampled);
    EXPECT_LT(one.low_bound, 0.5);
  }
  for (AxisBox& box : structures[0].box) {
    box.delay_s = {0.4, 0.402};
  }
  const std::vector<CertifiedLoop> late = certify(robust_design(), structures, 1.13, [](const CertifiedLoop&) {});
  EXPECT_FALSE(late[0].holds);
  EXPECT_NE(late[0].why_not.find("unstable"), std::string::npos) << late[0].why_not;
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
