// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <iostream>
#include <vector>

#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/tools/loop/close_loop.h"

namespace m100::tools::loop {

/// Plants that only the simulator knows: mixes of two or three effects.
struct Hidden {
  const char* name;
  void (*change)(sim::Plant&);
};
template <typename Change>
void both(sim::Plant& plant, Change change) {
  change(plant.roll);
  change(plant.pitch);
}

inline const std::vector<Hidden>& plants() {
  using Axis = model::AttitudeAxis;
  static const std::vector<Hidden> all{{"SlowAndLate",
                                        [](sim::Plant& p) {
                                          both(p, [](Axis& a) {
                                            a.natural_frequency_rad_s = 5.5;
                                            a.transport_delay_s = 0.08;
                                          });
                                        }},
                                       {"FirstOrderAndLate",
                                        [](sim::Plant& p) {
                                          both(p, [](Axis& a) {
                                            a.natural_frequency_rad_s = a.damping_ratio = 0.0;
                                            a.time_constant_s = 0.087;
                                            a.transport_delay_s = 0.107;
                                          });
                                        }},
                                       {"WeakWideDeadZone",
                                        [](sim::Plant& p) {
                                          both(p, [](Axis& a) {
                                            a.scale_rad_per_count = 6.5e-4;
                                            a.dead_zone_counts = 40.0;
                                          });
                                        }},
                                       {"AsymmetricLate",
                                        [](sim::Plant& p) {
                                          both(p, [](Axis& a) {
                                            a.gain_asymmetry = 1.5;
                                            a.transport_delay_s = 0.07;
                                          });
                                        }},
                                       {"CurvedAndSlow",
                                        [](sim::Plant& p) {
                                          both(p, [](Axis& a) {
                                            a.stick_exponent = 1.4;
                                            a.natural_frequency_rad_s = 6.0;
                                          });
                                        }},
                                       {"JumpingDeadZoneOtherTrim",
                                        [](sim::Plant& p) {
                                          both(p, [](Axis& a) {
                                            a.dead_zone_shape = model::DeadZoneShape::kJump;
                                            a.dead_zone_counts = 30.0;
                                            a.trim_counts = -60.0;
                                          });
                                        }},
                                       {"BacklashAndDelay",
                                        [](sim::Plant& p) {
                                          both(p, [](Axis& a) {
                                            a.backlash_counts = 12.0;
                                            a.transport_delay_s = 0.06;
                                          });
                                        }},
                                       {"WeaklyDampedInWind",
                                        [](sim::Plant& p) {
                                          both(p, [](Axis& a) { a.damping_ratio = 0.35; });
                                          p.air.linear_drag_per_s = 0.3;
                                          p.air.wind_m_s = {2.0, -1.0, 0.0};
                                          p.air.gust_m_s = 1.0;
                                        }},
                                       {"SluggishClimbStrongSticks",
                                        [](sim::Plant& p) {
                                          p.climb.natural_frequency_rad_s = 3.0;
                                          p.climb.dead_zone_counts = 70.0;
                                          both(p, [](Axis& a) { a.scale_rad_per_count = 1.3e-3; });
                                        }},
                                       {"RateLimitedAndLate",
                                        [](sim::Plant& p) {
                                          both(p, [](Axis& a) {
                                            a.rate_limit_rad_s = 0.8;
                                            a.transport_delay_s = 0.06;
                                          });
                                        }},
                                       {"CrossedWithLead",
                                        [](sim::Plant& p) {
                                          both(p, [](Axis& a) {
                                            a.cross_axis = 0.15;
                                            a.lead_zero_s = 0.12;
                                            a.natural_frequency_rad_s = 6.5;
                                            a.transport_delay_s = 0.06;
                                          });
                                        }},
                                       {"SlungLoadAndDelay", [](sim::Plant& p) {
                                          p.payload = {.mass_kg = 0.4, .slung_length_m = 1.2};
                                          both(p, [](Axis& a) { a.transport_delay_s = 0.08; });
                                        }}};
  return all;
}

/// Relative change of the trajectory error: -0.3 is 30 % better.
inline double change_on(const Hidden& hidden) {
  LoopOptions options;
  options.plant = sim::measured_plant();
  hidden.change(options.plant);
  options.vehicle = app::as_file(mpc::generated::kVehicle);
  options.tasks = {"trajectory"};
  options.work_folder = ::testing::TempDir();
  const LoopResult result = close_loop(options);
  const double before = trajectory_error_m(result.before.experiments);
  const double after = trajectory_error_m(result.after.experiments);
  std::cout << hidden.name << ": " << before << " m -> " << after << " m" << std::endl;
  return after / before - 1.0;
}

}  // namespace m100::tools::loop
