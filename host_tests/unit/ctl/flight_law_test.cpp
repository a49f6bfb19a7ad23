// SPDX-License-Identifier: BSD-3-Clause
// Compares the law with a reference implementation of its equations (flight_law.h), of parts that have their own tests.
#include "firmware/ctl/law/flight_law.h"

#include <gtest/gtest.h>

#include <cmath>

#include "firmware/ctl/law/slope_limit.h"
#include "firmware/mpc/generated/gain_table.h"

namespace m100::ctl {
namespace {

using mpc::kHorizon;
using References = std::array<ref::AxisReference<double>, kHorizon + 1>;

double seen_slope(double tilt_rad) { return std::tan(std::clamp(tilt_rad, -0.9, 0.9)); }

/// One horizontal axis of the reference implementation.
struct ReferenceAxis {
  ReferenceAxis(const mpc::GainTable<double>& gains, const model::StickAxis& stick, mpc::Law law)
      : table(gains), axis(stick), mpc(gains, law), predictor(gains.delay) {}

  double predicted_slope(const est::AxisEstimate<double>& now) const {
    const double slope = seen_slope(now.tilt_rad);
    return slope + (axis.transport_delay_s + 0.04) * now.tilt_rate_rad_s * (1.0 + slope * slope);
  }
  double slope(const est::AxisEstimate<double>& now, const References& reference, bool constant, double gap_s,
               double applied) {
    const double tilt = seen_slope(now.tilt_rad), offset = now.input_offset_rad * (1.0 + applied * applied);
    mpc::Problem<double> problem{.previous_input_slope = applied + offset,
                                 .disturbance_m_s2 = now.disturbance_m_s2,
                                 .constant_reference = constant};
    problem.state = predictor.predict({.position_m = now.position_m,
                                       .velocity_m_s = now.velocity_m_s,
                                       .tilt_slope = tilt,
                                       .tilt_slope_per_s = now.tilt_rate_rad_s * (1.0 + tilt * tilt),
                                       .disturbance_m_s2 = now.disturbance_m_s2,
                                       .input_offset_slope = offset});
    std::array<double, kHorizon + 2> target{};  // the first one is before the horizon, on the line of the next two
    for (std::size_t k = 0; k <= kHorizon; ++k) {
      target[k + 1] =
          table.tilt_sign / table.acceleration_per_tilt *
          (reference[k].acceleration_m_s2 + table.drag_per_s * reference[k].velocity_m_s - now.disturbance_m_s2);
    }
    target[0] = 2.0 * target[1] - target[2];
    const InverseLags lags = constant ? InverseLags{} : inverse_lags(axis);
    for (std::size_t k = 0; k < kHorizon; ++k) {
      const auto& [position_m, velocity_m_s, acceleration_m_s2] = reference[k + 1];
      const double rate = (target[k + 2] - target[k]) / 0.2;
      const double curvature = (target[k + 2] - 2.0 * target[k + 1] + target[k]) / 0.01;
      problem.input_ref_slope[k] =
          (target[k + 1] + lags.first_s * rate + lags.second_s2 * curvature) / table.input_gain;
      problem.tilt_ref_slope[k] = target[k + 2];
      problem.position_ref_m[k] = position_m + gap_s * velocity_m_s + 0.5 * gap_s * gap_s * acceleration_m_s2;
      problem.velocity_ref_m_s[k] = velocity_m_s + gap_s * acceleration_m_s2;
    }
    mpc.solve(problem, solution);
    return solution.input_slope[0] - offset;
  }

  const mpc::GainTable<double>& table;
  model::StickAxis axis;
  mpc::HorizontalMpc<double> mpc;
  mpc::DelayPredictor<double> predictor;
  mpc::Solution<double> solution{};
};

/// Both axes have other gains, limits and delays, so that no number of one is right for the other.
mpc::GainTables<double> tables() {
  mpc::GainTables<double> out{.x = mpc::generated::kX<double>, .y = mpc::generated::kY<double>};
  out.x.input_gain = 1.1;
  out.x.drag_per_s = 0.2;
  out.x.input_max_slope = 0.35;
  out.y.input_gain = 0.9;
  out.y.drag_per_s = 0.3;
  out.y.acceleration_per_tilt = 9.0;
  out.y.input_min_slope = -0.3;
  out.y.delay.ticks = 9;
  out.y.delay.delay_s = 0.095;
  return out;
}

struct FlightLawTest : ::testing::TestWithParam<mpc::Law> {
  const mpc::GainTables<double> gains = tables();
  const model::Vehicle vehicle = mpc::generated::kVehicle;
  FlightLaw<double> law{vehicle, gains, {.horizontal = GetParam()}};
  ReferenceAxis x{gains.x, model::flown_pitch(vehicle), GetParam()};
  ReferenceAxis y{gains.y, model::flown_roll(vehicle), GetParam()};
  FallbackLaw<double> slow_x, slow_y;
  est::Estimate<double> estimate;
  ref::Window<double> window;
  double fallback_per_s = 0.0;

  FlightLawTest() {
    estimate.x = {0.3, -0.4, 0.10, 0.3, 0.5, 0.02};
    estimate.y = {-0.2, 0.5, -0.15, -0.2, -0.8, -0.03};
    estimate.yaw_rad = 0.7;
    for (std::size_t k = 0; k < window.x.size(); ++k) {
      const double s = 0.1 * static_cast<double>(k);
      window.x[k] = {0.3 * s * s, 0.6 * s, 0.6 - 0.2 * s * s};
      window.y[k] = {-0.1 - 0.2 * s, -0.2 + 0.1 * s, 0.3 * s * s};
    }
  }
  /// One tick of the law and of the reference implementation: equal commands.
  void compare(const Command<double>& applied, int ticks, bool tilt_limited) {
    const core::Slope<double> commanded = core::slope_of(core::attitude_sin_cos(
        core::Euler<double>{.roll_rad = applied.roll_rad, .pitch_rad = applied.pitch_rad, .yaw_rad = 0.7}));
    const double applied_x = seen_slope(std::atan(commanded.x)), applied_y = seen_slope(std::atan(commanded.y));
    for (int tick = 0; tick < ticks; ++tick) {
      x.predictor.sent(applied_x);
      y.predictor.sent(applied_y);
    }
    const double gap_s = 0.095 - static_cast<double>(law.lead().count()) * 1e-6;
    double slope_x = x.slope(estimate.x, window.x, window.constant, 0.0, applied_x);
    double slope_y = y.slope(estimate.y, window.y, window.constant, gap_s, applied_y);
    if (fallback_per_s > 0.0) {
      slope_x = slow_x.slope(estimate.x, window.x[0], gains.x, fallback_per_s, 0.01 * ticks);
      slope_y = slow_y.slope(estimate.y, window.y[0], gains.y, fallback_per_s, 0.01 * ticks);
    }
    const double most =
        max_slope(x.predicted_slope(estimate.x), y.predicted_slope(estimate.y), std::tan(core::kPi / 6.0));
    const double share = std::min(1.0, most / std::hypot(slope_x, slope_y));
    const core::Euler<double> wanted =
        core::attitude_of(core::Slope<double>{share * slope_x, share * slope_y}, 0.7, core::sin_cos_of(0.7));
    const Command<double> command = law.update(estimate, window, applied, ticks * core::kTickPeriod);
    EXPECT_NEAR(command.pitch_rad, wanted.pitch_rad, 1e-9);
    EXPECT_NEAR(command.roll_rad, wanted.roll_rad, 1e-9);
    EXPECT_EQ(law.report().path_x, x.solution.path);
    EXPECT_EQ(law.report().path_y, y.solution.path);
    EXPECT_EQ(law.report().changes, x.solution.changes + y.solution.changes);
    EXPECT_EQ(law.report().tilt_limited, tilt_limited);
    EXPECT_EQ(share < 1.0, tilt_limited) << share;
    EXPECT_EQ(law.report().fallback, fallback_per_s > 0.0);
  }
};
INSTANTIATE_TEST_SUITE_P(Laws, FlightLawTest, ::testing::Values(mpc::Law::kMpc, mpc::Law::kLqr),
                         [](const auto& tested) { return std::string(name(tested.param)); });

// Catches a wrong sign, factor, place or axis of any term, in hover, on a course, at the limits and in the fallback.
TEST_P(FlightLawTest, CommandsWhatItsEquationsSay) {
  EXPECT_FALSE(law.report().fallback || law.report().tilt_limited || law.report().changes != 0);
  compare({.roll_rad = -0.05, .pitch_rad = 0.12}, 1, false);
  compare({.roll_rad = 0.08, .pitch_rad = -0.1}, 3, false);
  estimate.x.tilt_rad = 1.2;  // pushed over: beyond 0.9 rad a tangent is of no use
  compare({.roll_rad = 0.08, .pitch_rad = -1.3}, 2, true);
  estimate.x = {-3.0, 1.0, 0.35, 0.4};
  estimate.y = {4.0, 0.2, 0.40, 0.6};
  compare({.roll_rad = 0.08, .pitch_rad = -0.1}, 1, true);
  law.reset();
  x.mpc.reset(), y.mpc.reset();
  compare({.roll_rad = 0.08, .pitch_rad = -0.1}, 1, true);
  window.constant = true;
  window.x.fill({.position_m = 0.5});
  window.y.fill({.position_m = -0.25});
  estimate.x = {0.3, -0.2, 0.1, 0.3, 0.5, 0.02};
  estimate.y = {-0.2, 0.3, -0.1, -0.2, -0.8, -0.03};
  compare({.roll_rad = 0.02, .pitch_rad = 0.03}, 1, false);
  fallback_per_s = 0.7;
  law.start_fallback(fallback_per_s);
  compare({.roll_rad = 0.02, .pitch_rad = 0.03}, 1, false);
  estimate.x.disturbance_m_s2 = estimate.y.disturbance_m_s2 = -1.0;
  compare({.roll_rad = 0.02, .pitch_rad = 0.03}, 2, false);
  law.reset();
  x.mpc.reset(), y.mpc.reset(), slow_x.reset(), slow_y.reset();
  fallback_per_s = 0.0;
  compare({.roll_rad = 0.02, .pitch_rad = 0.03}, 1, false);
  law.start_fallback(fallback_per_s = 0.7);
  compare({.roll_rad = 0.02, .pitch_rad = 0.03}, 1, false);
}

// The trim is an angle, and the laws compute with tangents. Steadily leaned against the wind by 22 degrees, each law
// must command the flown angle less the trim; adding the angle to the tangent would miss 16 % of the trim.
TEST_P(FlightLawTest, TrimsASteepTiltByTheWholeAngle) {
  constexpr double kFlown_rad = 0.384, kTrim_rad = 0.03;
  const mpc::GainTables<double> shipped{.x = mpc::generated::kX<double>, .y = mpc::generated::kY<double>};
  const double tilt_slope = shipped.x.input_gain * std::tan(kFlown_rad);
  estimate = {};
  estimate.x.tilt_rad = std::atan(tilt_slope);
  estimate.x.disturbance_m_s2 = -shipped.x.tilt_sign * shipped.x.acceleration_per_tilt * tilt_slope;
  estimate.x.input_offset_rad = kTrim_rad;
  window = {};
  window.constant = true;
  FlightLaw<double> steady{vehicle, shipped, {.horizontal = GetParam()}};
  const Command<double> applied{.pitch_rad = kFlown_rad - kTrim_rad};
  Command<double> command;
  for (int tick = 0; tick < 40; ++tick) {
    command = steady.update(estimate, window, applied, core::kTickPeriod);
  }
  EXPECT_NEAR(command.pitch_rad, applied.pitch_rad, 0.04 * kTrim_rad);
  FallbackLaw<double> fallback;
  EXPECT_NEAR(std::atan(fallback.slope(estimate.x, {}, shipped.x, 0.7, 0.01)), applied.pitch_rad, 0.04 * kTrim_rad);
}

TEST_P(FlightLawTest, HasTheLeadOfPitchAndTheSlopeOfTheNarrowestLimit) {
  EXPECT_EQ(law.lead(), x.predictor.lead());
  EXPECT_NEAR(law.slope_limit(), 0.9 * 0.3, 1e-12) << "roll's lower limit";
  mpc::GainTables<double> other = gains;
  other.y.input_min_slope = -0.46;
  EXPECT_NEAR(FlightLaw<double>(vehicle, other).slope_limit(), 1.1 * 0.35, 1e-12) << "pitch's upper limit";
  other.x.input_max_slope = other.y.input_max_slope = 0.6;
  other.x.input_min_slope = other.y.input_min_slope = -0.6;
  EXPECT_NEAR(FlightLaw<double>(vehicle, other).slope_limit(), std::tan(core::kPi / 6.0) / std::sqrt(2.0), 1e-12);
}

// Height and heading, with each kind of climb loop; a tick that does not solve keeps the tilts and reads no x and y.
TEST_P(FlightLawTest, FliesHeightAndHeadingAlsoWhereItDoesNotSolve) {
  model::StickAxis quick = vehicle.climb, first = vehicle.climb;
  quick.natural_frequency_rad_s = 0.0;
  first.time_constant_s = 0.4;
  const double second_s = 2.0 * vehicle.climb.damping_ratio / vehicle.climb.natural_frequency_rad_s;
  estimate.height_m = 1.9;
  estimate.climb_m_s = 0.1;
  window.height = {.position_m = 2.0, .velocity_m_s = 0.3, .acceleration_m_s2 = 0.5};
  window.yaw_rad = 0.8;
  window.yaw_rate_rad_s = 0.05;
  for (auto [climb, lag_s] : {std::pair{vehicle.climb, second_s}, {first, 0.4}, {quick, 0.0}}) {
    climb.transport_delay_s = 0.1;
    for (const bool design : {true, false}) {
      model::Vehicle other = vehicle;
      other.climb = climb;
      other.altitude.design = design;
      AltitudePid<double> height(design ? design_altitude(climb, other.altitude) : other.altitude);
      FlightLaw<double> flown(other, gains);
      const Command<double> solved = flown.update(estimate, window, {}, core::kTickPeriod);
      const HeightReference<double> wanted{2.0, 0.3, 0.3 + (0.1 + lag_s) * 0.5};
      const double climb_m_s = height.update(wanted, 1.9, 0.1, 0.01);
      EXPECT_NEAR(solved.climb_m_s, climb_m_s, 1e-12) << lag_s;
      EXPECT_NEAR(solved.yaw_rate_rad_s, 0.05 + 1.5 * 0.1, 1e-12);
      const Command<double> kept = flown.update(estimate, {.height = window.height}, {}, 2 * core::kTickPeriod, false);
      EXPECT_EQ(kept.pitch_rad, solved.pitch_rad);
      EXPECT_EQ(kept.roll_rad, solved.roll_rad);
      EXPECT_NEAR(kept.climb_m_s, height.update(wanted, 1.9, 0.1, 0.02), 1e-12);
      EXPECT_NEAR(kept.yaw_rate_rad_s, -1.0, 1e-12) << "1.5 * -0.7, limited";
      flown.reset();
      EXPECT_NEAR(flown.update(estimate, window, {}, core::kTickPeriod).climb_m_s, climb_m_s, 1e-12);
    }
  }
}

// A jump of the set point becomes a motion, but not for the fallback law.
TEST_P(FlightLawTest, PlansTheWayToASetPointWhileItFliesItself) {
  const GeofenceLimiter<double> fence(core::Fence{}, ctl::braking_of(vehicle, law.slope_limit()));
  ref::Window<double> jump;
  jump.constant = true;
  jump.x.fill({.position_m = 5.0});
  law.plan(jump, {}, fence, core::TimePoint(std::chrono::seconds(1)), jump.x.size());
  EXPECT_FALSE(jump.constant);
  law.reset();
  est::Estimate<double> elsewhere;
  elsewhere.x.position_m = 3.0;
  jump.constant = true;
  jump.x.fill({.position_m = 5.0});
  law.plan(jump, elsewhere, fence, core::TimePoint(std::chrono::seconds(1)), jump.x.size());
  EXPECT_EQ(jump.x[0].position_m, 3.0) << "the motion from before the reset is forgotten";
  law.start_fallback(0.5);
  jump.constant = true;
  jump.x.fill({.position_m = 5.0});
  law.plan(jump, {}, fence, core::TimePoint(std::chrono::seconds(2)), jump.x.size());
  EXPECT_TRUE(jump.constant);
}

}  // namespace
}  // namespace m100::ctl
