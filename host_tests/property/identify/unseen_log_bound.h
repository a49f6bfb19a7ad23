// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/property/identify/unseen_log_vehicle.h"

namespace m100::host_tests {

/// Noise of a log, and its sample period.
struct UnseenLogNoise {
  double air = 0.0;     ///< standard deviation of the disturbance by the air, first-order coloured
  double air_s = 1.0;   ///< its time constant
  double white = 0.0;   ///< of the sensor, including rounding
  double row_s = 0.01;  ///< between two rows
};

/// Upper bound of the evidence in a log: twice the expected log-likelihood ratio of the true vehicle against the most
/// likely vehicle of the declared model, for an observer who knows the colour and size of the noise. It is the minimum,
/// over the declared parameters (Gauss-Newton, delay not below zero, free offset), of the sum of squares of the
/// difference of both noise-free responses. The difference is whitened by the innovations of the noise (Kalman filter
/// of a first-order process under white noise). A ratio decided at L is seen in 19 of 20 logs if this bound is
/// (sqrt(L) + 1.64)^2.
/// @param truth  noise-free response, one value for each row; @param rows  simulation step of each row
/// @param believed  vehicle to start from; @param declared  as in a request, with or without dead_zone and trim_offset
double evidence_of(const std::vector<double>& truth, const std::vector<std::size_t>& rows,
                   const UnseenLogSticks& sticks, UnseenLogParameters believed,
                   const std::vector<std::string>& declared, const UnseenLogNoise& noise);

/// Bound at which 19 of 20 logs reach the ratio that identify requires for a change (axis_change_point.cpp).
inline constexpr double kUnseenLogVisible = 50.7;  // (sqrt(30) + 1.64)^2

}  // namespace m100::host_tests
