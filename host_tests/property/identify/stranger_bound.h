// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/property/identify/stranger_vehicle.h"

namespace m100::host_tests {

/// What a log holds beside the response, and how often it was written.
struct StrangerNoise {
  double air = 0.0;     ///< standard deviation of the air that moves the vehicle, first-order coloured
  double air_s = 1.0;   ///< its time constant
  double white = 0.0;   ///< of the sensor, rounding among it
  double row_s = 0.01;  ///< between two rows
};

/// Upper bound of what a log can tell: twice the logarithm of the likelihood ratio, as expected, of the true vehicle
/// against the likeliest vehicle of the declared model, to one who knows the noise's colour and strength. It is the
/// least sum of squares of the difference of both noise-free responses, made white by the innovations of the noise
/// (Kalman filter of a first-order process under white noise), over the declared parameters (Gauss-Newton, a delay
/// not below zero, an offset free). A ratio decided at L is seen in 19 of 20 logs where this is (sqrt(L) + 1.64)^2.
/// @param truth  noise-free response, one value for each row; @param rows  steps of the simulation at which they stand
/// @param believed  vehicle to start from; @param declared  as in a request: dead_zone and trim_offset among it or not
double evidence_of(const std::vector<double>& truth, const std::vector<std::size_t>& rows, const StrangerSticks& sticks,
                   StrangerTraits believed, const std::vector<std::string>& declared, const StrangerNoise& noise);

/// What identify asks of a likelihood ratio before it names a change (axis_change.cpp), seen in 19 of 20 logs.
inline constexpr double kStrangerVisible = 50.7;  // (sqrt(30) + 1.64)^2

}  // namespace m100::host_tests
