// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>

#include "firmware/est/filter/disturbance_ekf.h"
#include "firmware/model/vehicle.h"
#include "firmware/ref/window.h"

#include "host_tests/lab/gains/margins.h"

namespace m100::scenario {

/// The world of the closed-loop figures: two tilt axes, each with its own dynamics and delay; a point mass with
/// g tan(tilt) and drag; wind as an acceleration; climb and yaw axes of first order. Commands arrive as angles: other
/// tests cover sticks, dead zones and the wire. Deliberately independent of host_tests/sim, as a second opinion.
struct World {
  double natural_frequency_rad_s = 9.36;
  double damping_ratio = 0.68;
  double time_constant_s = 0.0;  ///< above 0: first order
  double delay_s = 0.033;
  double drag_per_s = 0.01;
  double trim_rad = 0.0;      ///< added to the command of both axes
  double command_gain = 1.0;  ///< of the attitude loop
  double wind_m_s2 = 0.0;     ///< mean, along x and half of it along y
  double gust_m_s2 = 0.0;     ///< standard deviation, correlated over gust_s
  double gust_s = 1.0;
  double pose_sigma_m = 0.002;
  double attitude_sigma_rad = 0.3 * 3.14159265358979 / 180.0;
  double rate_sigma_rad_s = 0.01;
  double pose_delay_s = 0.0;
  double command_period_s = 0.01;  ///< between two commands; the last one is held
  double climb_time_constant_s = 0.334;
  double climb_delay_s = 0.08;
  double yaw_rad = 0.0;  ///< heading at the start
  std::uint32_t seed = 1;
};

/// The bench's timing for margins: a command in every tick, as an angle; attitude and pose without age.
inline constexpr lab::gains::LoopTiming kBenchTiming{
    .command_ticks = 1, .attitude_age_ticks = 0, .pose_age_ticks = 0, .by_sticks = false};

World plant_a();  ///< second order, 9.36 rad/s, damping 0.68, delay 33 ms
World plant_b();  ///< first order, 87 ms, delay 107 ms

/// A vehicle model with this world's dynamics and delays, but not its wind, trim or gain; weights as given.
model::Vehicle vehicle_of(const World& world);

struct Flight {
  double duration_s = 30.0;
  double settle_s = 10.0;  ///< at the start; not part of the result
  std::function<ref::Window<double>(double now_s, double lead_s)> reference;
  std::function<bool(double now_s)> pose_lost = [](double) { return false; };
  std::function<void(double now_s, World& world)> change = [](double, World&) {};
};

struct Result {
  double x_rms_m = 0.0, y_rms_m = 0.0, z_rms_m = 0.0;
  double x_mean_m = 0.0, y_mean_m = 0.0;
  double position_peak_m = 0.0;      ///< horizontal, after settling
  double tilt_rms_deg = 0.0;         ///< of the worse axis, about its mean
  double input_variation_deg = 0.0;  ///< root mean square of the command's change per tick
  double end_error_m = 0.0;          ///< mean horizontal error of the last second
  est::EkfCounters ekf;
  bool finite = true;
};

/// The flights are equal, bit for bit, on every machine. A limit is the measured result times this, for intended
/// changes of the law; a larger regression has to be explained beside the result.
inline constexpr double kMargin = 1.5;

/// Flies the law in T (double or float) and the filter in S.
template <typename S, typename T>
Result fly(const World& world, const model::Vehicle& vehicle, const Flight& flight);

Flight hover(double duration_s);  ///< 1 m above the origin
/// Quintics between waypoints, 2.5 s each.
Result fly_waypoints(const World& world, const model::Vehicle& vehicle);

/// References.
ref::Window<double> hover_at(double x_m, double y_m, double z_m);
ref::Window<double> sinusoid(double amplitude_m, double rate_rad_s, double now_s, double lead_s);

}  // namespace m100::scenario
