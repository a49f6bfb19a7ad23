// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/loop/close_loop.h"
#include "host_tests/sim/world/base_plant.h"
#include "host_tests/sim/world/plant_file.h"

namespace m100::lab::loop {

/// A plant that only the simulator knows: a mix of two or three effects.
struct Hidden {
  const char* name;
  void (*tilt)(model::StickAxis&);                 ///< changes roll and pitch
  void (*rest)(sim::Plant&) = [](sim::Plant&) {};  ///< changes the rest of the plant
};

inline constexpr std::array kHiddenPlants{
    Hidden{"SlowAndLate",
           [](model::StickAxis& a) {
             a.natural_frequency_rad_s = 5.5;
             a.transport_delay_s = 0.08;
           }},
    Hidden{"FirstOrderAndLate",
           [](model::StickAxis& a) {
             a.natural_frequency_rad_s = a.damping_ratio = 0.0;
             a.time_constant_s = 0.087;
             a.transport_delay_s = 0.107;
           }},
    Hidden{"WeakWideDeadZone",
           [](model::StickAxis& a) {
             a.scale_per_count = 6.5e-4;
             a.dead_zone_counts = 40.0;
           }},
    Hidden{"AsymmetricLate",
           [](model::StickAxis& a) {
             a.gain_asymmetry = 1.5;
             a.transport_delay_s = 0.07;
           }},
    Hidden{"CurvedAndSlow",
           [](model::StickAxis& a) {
             a.stick_exponent = 1.4;
             a.natural_frequency_rad_s = 6.0;
           }},
    Hidden{"JumpingDeadZoneOtherTrim",
           [](model::StickAxis& a) {
             a.dead_zone_shape = model::DeadZoneShape::kJump;
             a.dead_zone_counts = 30.0;
             a.trim_counts = -60.0;
           }},
    Hidden{"BacklashAndDelay",
           [](model::StickAxis& a) {
             a.backlash_counts = 12.0;
             a.transport_delay_s = 0.06;
           }},
    Hidden{"WeaklyDampedInWind", [](model::StickAxis& a) { a.damping_ratio = 0.35; },
           [](sim::Plant& plant) {
             plant.air.linear_drag_per_s = 0.3;
             plant.air.wind_m_s = {2.0, -1.0, 0.0};
             plant.air.gust_m_s = 1.0;
           }},
    Hidden{"SluggishClimbStrongSticks", [](model::StickAxis& a) { a.scale_per_count = 1.3e-3; },
           [](sim::Plant& plant) {
             plant.climb.natural_frequency_rad_s = 3.0;
             plant.climb.dead_zone_counts = 70.0;
           }},
    Hidden{"RateLimitedAndLate",
           [](model::StickAxis& a) {
             a.rate_limit_per_s = 0.8;
             a.transport_delay_s = 0.06;
           }},
    Hidden{"CrossedWithLead",
           [](model::StickAxis& a) {
             a.cross_axis = 0.15;
             a.lead_zero_s = 0.12;
             a.natural_frequency_rad_s = 6.5;
             a.transport_delay_s = 0.06;
           }},
    Hidden{"SlungLoadAndDelay", [](model::StickAxis& a) { a.transport_delay_s = 0.08; },
           [](sim::Plant& plant) { plant.payload = {.mass_kg = 0.4, .slung_length_m = 1.2}; }},
};

/// What the loop finds, by default with the project's vehicle file, without tables before and after.
inline LoopResult found_on(const sim::Plant& plant, std::uint64_t seed,
                           const companion::VehicleFile& vehicle = companion::as_file(mpc::generated::kVehicle)) {
  LoopOptions options;
  options.plan.plant = plant;
  options.plan.vehicle = vehicle;
  options.seed = seed;
  options.tasks = {};
  return close_loop(options);
}

/// If the vehicle file itself is the plant, the loop must find nothing: no effect, no significant number, no change.
inline void expect_nothing_found(std::uint64_t seed) {
  const LoopResult result = found_on(sim::plant_of_options("", M100_VEHICLE_FILE), seed);
  EXPECT_TRUE(result.taken_over.empty()) << "seed " << seed << ": " << ::testing::PrintToString(result.taken_over);
  for (const auto& [channel, found] : result.identified) {
    EXPECT_TRUE(found.effects.empty()) << "seed " << seed << ": " << channel << " " << found.effects.front().name;
  }
  for (const auto& [channel, rows] : result.believed_found) {
    for (const identify::Refitted& one : rows) {
      EXPECT_FALSE(one.matters) << "seed " << seed << ": " << channel << " " << one.parameter << " " << one.believed
                                << " -> " << one.found.value;
      // The yaw sticks jump over their dead zone, so its width is not observable, and must not be reported as zero.
      if (channel == "yaw_rate" && one.parameter == "dead_zone_counts") {
        EXPECT_LE(one.found.low, one.believed) << "seed " << seed;
        EXPECT_GE(one.found.high, one.believed) << "seed " << seed;
      }
    }
  }
}

/// Channels whose verdict is not "nothing missing" although this vehicle file is the plant, with the reasons.
inline std::string without_a_clean_bill(std::uint64_t seed, const std::string& vehicle_file) {
  const LoopResult result =
      found_on(sim::plant_of_options("", vehicle_file), seed, companion::load_vehicle(vehicle_file));
  std::string out;
  for (const auto& [channel, found] : result.identified) {
    if (found.verdict != "nothing_missing") {
      out += "seed " + std::to_string(seed) + ": " + channel + " " + ::testing::PrintToString(found.unexplained) + "\n";
    }
  }
  return out;
}

/// Pose RMS of the trajectory task, calm and windy together; a flight that never began counts as 1 km.
inline double trajectory_error_m(const std::vector<experiments::TaskResult>& results) {
  double sum_m2 = 0.0;
  double count = 0.0;
  for (const experiments::TaskResult& result : results) {
    if (result.task->task == "trajectory") {
      sum_m2 += result.refused > 0 ? 1e6 : result.mean.pose_m * result.mean.pose_m;
      count += 1.0;
    }
  }
  return count > 0.0 ? std::sqrt(sum_m2 / count) : 0.0;
}

/// Root mean square of the pose error on the trajectory, before and after the loop.
struct Errors {
  double before_m = 0.0;
  double after_m = 0.0;
  double change() const { return after_m / before_m - 1.0; }  ///< -0.3 is 30 % better
};

inline sim::Plant plant_of(const Hidden& hidden) {
  sim::Plant plant = sim::measured_plant();
  hidden.tilt(plant.roll);
  hidden.tilt(plant.pitch);
  hidden.rest(plant);
  return plant;
}

/// Runs the loop on one hidden plant, with the trajectory flown before and after.
inline LoopResult closed_on(const Hidden& hidden) {
  LoopOptions options;
  options.plan.plant = plant_of(hidden);
  options.plan.vehicle = companion::as_file(mpc::generated::kVehicle);
  options.tasks = {"trajectory"};
  return close_loop(options);
}

inline Errors errors_of(const LoopResult& result) {
  return {.before_m = trajectory_error_m(result.before.experiments),
          .after_m = trajectory_error_m(result.after.experiments)};
}

inline Errors errors_on(const Hidden& hidden) { return errors_of(closed_on(hidden)); }

}  // namespace m100::lab::loop
