// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/experiments/flight.h"
#include "host_tests/lab/gains/margins.h"

namespace m100::lab::experiments {

/// Time on the line. The attitude loop of the simulated autopilot comes one cycle of 100 Hz later (command_delay_s).
inline constexpr double kLine_s = 0.001;

/// A vehicle near the measured one, with drawn frequency, damping, stick scale and delay. The dead zone is the one of
/// the vehicle file, so that the loop is linear.
inline sim::Plant drawn_plant(unsigned number) {
  std::mt19937 random(7000 + number);
  const auto between = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  sim::Plant plant = sim::measured_plant();
  const model::Vehicle& believed = mpc::generated::kVehicle;
  for (auto [axis, own] : {std::pair{&plant.roll, &believed.roll}, {&plant.pitch, &believed.pitch}}) {
    axis->natural_frequency_rad_s *= between(0.85, 1.25);
    axis->damping_ratio *= between(0.9, 1.2);
    axis->scale_per_count = own->scale_per_count * between(0.85, 1.15);
    axis->transport_delay_s += between(0.0, 0.015);
    axis->dead_zone_counts = own->dead_zone_counts;
    axis->trim_counts = 0.0;
  }
  plant.air.attitude_disturbance_rad = 0.001;
  return plant;
}

inline model::Vehicle as_vehicle(const sim::Plant& plant) {
  model::Vehicle out = mpc::generated::kVehicle;
  out.roll = plant.roll;
  out.pitch = plant.pitch;
  for (model::StickAxis* axis : {&out.roll, &out.pitch}) {
    axis->transport_delay_s += plant.link.command_delay_s + kLine_s;
  }
  return out;
}

/// Tilt of an axis about its mean in the last ten of forty seconds of hover, degrees rms.
inline double hover_tilt_deg(sim::Plant plant, gains::Axis axis, link::Channel channel, double extra_delay_s) {
  plant.link.command_delay_s += extra_delay_s;
  FlightPlan plan;
  plan.plant = plant;
  plan.vehicle = companion::as_file(mpc::generated::kVehicle);
  plan.course = "step 0 0 0 0 45\n";
  plan.duration_s = 40.0;
  plan.channel = channel;
  plan.responds_to_limit_cycles = false;
  const FlightResult flight = fly(plan);
  double sum = 0.0;
  double squares = 0.0;
  double count = 0.0;
  for (const TracePoint& point : flight.trace) {
    if (point.t_s > 30.0) {
      const double tilt_rad = axis == gains::Axis::kX ? point.pitch_rad : point.roll_rad;
      sum += tilt_rad;
      squares += tilt_rad * tilt_rad;
      count += 1.0;
    }
  }
  EXPECT_GT(count, 900.0) << "the aircraft did not fly";
  const double mean = sum / count;
  return std::sqrt(std::max(0.0, squares / count - mean * mean)) * 180.0 / std::numbers::pi;
}

/// Limit of a limit cycle, between the two bounds of a campaign (2 degrees in hover, 3 in general): a healthy hover has
/// half a degree, a limit cycle reaches ten and more.
inline constexpr double kSwings_deg = 2.5;

/// The axis with the smaller margin must not swing with 0.9 times the delay margin, and must swing with 1.1 times.
inline void expect_onset_where_predicted(unsigned number, link::Channel channel) {
  const sim::Plant plant = drawn_plant(number);
  const gains::LoopTiming& timing =
      channel == link::Channel::kMovement ? gains::kMovementTiming : gains::kVirtualRcTiming;
  const auto margins = [&](gains::Axis axis) {
    return gains::flown_margins_of(mpc::generated::kVehicle, as_vehicle(plant), axis, timing);
  };
  const gains::Margins x = margins(gains::Axis::kX);
  const gains::Margins y = margins(gains::Axis::kY);
  const gains::Axis axis = x.delay_margin_s <= y.delay_margin_s ? gains::Axis::kX : gains::Axis::kY;
  const gains::Margins& weaker = axis == gains::Axis::kX ? x : y;
  ASSERT_TRUE(weaker.stable);
  ASSERT_LT(weaker.delay_margin_s, gains::kLargestDelay_s - 0.1);
  EXPECT_LT(hover_tilt_deg(plant, axis, channel, 0.9 * weaker.delay_margin_s), kSwings_deg)
      << "vehicle " << number << ", predicted " << weaker.delay_margin_s << " s";
  EXPECT_GT(hover_tilt_deg(plant, axis, channel, 1.1 * weaker.delay_margin_s), kSwings_deg)
      << "vehicle " << number << ", predicted " << weaker.delay_margin_s << " s";
}

}  // namespace m100::lab::experiments
