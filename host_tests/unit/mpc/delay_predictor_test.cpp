// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/mpc/delay_predictor.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <deque>
#include <random>

#include "host_tests/lab/gains/gain_tables.h"

namespace m100::mpc {
namespace {

using lab::gains::Axis;

struct Case {
  const char* name;
  double time_constant_s, natural_frequency_rad_s, damping_ratio, delay_s, lead_zero_s;
};

/// The same axis with its delay, integrated from the differential equations in steps of 10 us.
class FineAxis {
 public:
  FineAxis(const Case& axis, double sign, double disturbance, double offset)
      : axis_(axis), sign_(sign), disturbance_(disturbance), offset_(offset) {}

  void run_tick(double input_slope) {
    inputs_.push_back(input_slope);
    for (int i = 0; i < kSteps; ++i, ++steps_) {
      step();
    }
  }
  void continue_for(double time_s) {
    inputs_.push_back(inputs_.back());  // not effective yet, so its value does not matter
    for (int i = 0; i < static_cast<int>(std::lround(time_s / kStep_s)); ++i, ++steps_) {
      step();
    }
  }
  AxisState<double> seen() const {
    const double rate = chi_rate();
    return {.position_m = p_,
            .velocity_m_s = v_,
            .tilt_slope = chi_ + axis_.lead_zero_s * rate,
            .tilt_slope_per_s = axis_.time_constant_s > 0 ? 0.0 : rate + axis_.lead_zero_s * chi_acceleration(),
            .disturbance_m_s2 = disturbance_,
            .input_offset_slope = offset_};
  }
  std::array<double, kMaxStates> states() const { return {p_, v_, chi_, axis_.time_constant_s > 0 ? 0.0 : chi_rate_}; }

 private:
  static constexpr double kStep_s = 1e-5;
  static constexpr int kSteps = 1000;

  double acting() const {
    const long k = std::lround(std::floor((static_cast<double>(steps_) * kStep_s - axis_.delay_s) / 0.01 + 1e-9));
    return (k < 0 ? 0.0 : inputs_.at(static_cast<std::size_t>(k))) + offset_;
  }
  double chi_rate() const {
    return axis_.time_constant_s > 0 ? (last_acting_ - chi_) / axis_.time_constant_s : chi_rate_;
  }
  double chi_acceleration() const {
    const double w = axis_.natural_frequency_rad_s;
    return w * w * (last_acting_ - chi_) - 2 * axis_.damping_ratio * w * chi_rate_;
  }
  void step() {
    last_acting_ = acting();
    const double tilt = chi_ + axis_.lead_zero_s * chi_rate();
    const double acceleration = sign_ * model::kGravity_m_s2 * tilt - 0.01 * v_ + disturbance_;
    p_ += kStep_s * v_ + 0.5 * kStep_s * kStep_s * acceleration;
    v_ += kStep_s * acceleration;
    if (axis_.time_constant_s > 0) {
      chi_ += kStep_s * chi_rate();
    } else {
      const double rate = chi_rate_ + kStep_s * chi_acceleration();
      chi_ += kStep_s * 0.5 * (rate + chi_rate_);
      chi_rate_ = rate;
    }
  }

  Case axis_;
  double sign_, disturbance_, offset_;
  double p_ = 0.3, v_ = -0.2, chi_ = 0.05, chi_rate_ = 0.1, last_acting_ = 0.0;
  std::deque<double> inputs_;
  long steps_ = 0;
};

class DelayPredictorTable : public ::testing::TestWithParam<Case> {};

// Catches inputs used one tick too early or too late, and an ignored fraction of a tick: either changes the tilt by
// 1e-3.
TEST_P(DelayPredictorTable, SeesWhereTheVehicleWillBeWhenTheNextInputActs) {
  const Case& axis = GetParam();
  for (const Axis which : {Axis::kX, Axis::kY}) {
    model::Vehicle vehicle;
    model::StickAxis& attitude = which == Axis::kX ? vehicle.pitch : vehicle.roll;
    attitude.time_constant_s = axis.time_constant_s;
    attitude.natural_frequency_rad_s = axis.natural_frequency_rad_s;
    attitude.damping_ratio = axis.damping_ratio;
    attitude.transport_delay_s = axis.delay_s;
    attitude.lead_zero_s = axis.lead_zero_s;
    const DelayModel<double> model = lab::gains::make_delay_model(vehicle, which);
    DelayPredictor<double> predictor(model);
    EXPECT_NEAR(core::seconds<double>(predictor.lead()), axis.delay_s, 1e-6);
    FineAxis truth(axis, which == Axis::kX ? 1.0 : -1.0, 0.8, 0.03);
    predictor.reset(0.0);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> input(-0.4, 0.4);
    for (int tick = 0; tick < 40; ++tick) {
      const double u = input(random);
      truth.run_tick(u);
      predictor.sent(u);
    }
    const std::array<double, kMaxStates> predicted = predictor.predict(truth.seen());
    truth.continue_for(axis.delay_s);
    const std::array<double, kMaxStates> reached = truth.states();
    for (std::size_t i = 0; i < kMaxStates; ++i) {
      EXPECT_NEAR(predicted.at(i), reached.at(i), i == 3 ? 2e-3 : 2e-4) << "state " << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Axes, DelayPredictorTable,
                         ::testing::Values(Case{"NoDelay", 0.087, 0, 0, 0.0, 0.0},
                                           Case{"FirstOrder107ms", 0.087, 0, 0, 0.107, 0.0},
                                           Case{"SecondOrder33ms", 0, 9.36, 0.68, 0.033, 0.0},
                                           Case{"WholeTicks", 0, 9.36, 0.68, 0.05, 0.0},
                                           Case{"LongestDelay", 0, 8.69, 0.682, 0.3, 0.0},
                                           Case{"SecondOrderWithLeadZero", 0, 8.69, 0.682, 0.07, 0.04},
                                           Case{"FirstOrderWithLeadZero", 0.2, 0, 0, 0.025, 0.05}),
                         [](const auto& tested) { return tested.param.name; });

TEST(DelayPredictor, RemembersAsManyInputsAsTheLongestDelayNeeds) {
  DelayModel<float> model;
  model.ticks = 30;
  DelayPredictor<float> predictor(model);
  for (int i = 1; i <= 100; ++i) {
    predictor.sent(static_cast<float>(i));
  }
  EXPECT_EQ(predictor.sent_ago(1), 100.F);
  EXPECT_EQ(predictor.sent_ago(31), 70.F);
}

}  // namespace
}  // namespace m100::mpc
