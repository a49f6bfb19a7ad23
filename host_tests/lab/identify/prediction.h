// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "firmware/model/vehicle.h"
#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::identify {

/// Root mean square error of the prediction of a vehicle file from the sticks of a log, at each of kHorizons_s, with a
/// start every 0.1 s from the measured state. Position (zero if it was not logged) and velocity are horizontal, in the
/// world frame, with the measured heading; the velocity is the position's derivative() if it was not logged. Their mean
/// error is subtracted, because it is the wind that the observer learns in flight.
struct Prediction {
  HorizonErrors roll_rad{};
  HorizonErrors pitch_rad{};
  HorizonErrors position_m{};
  HorizonErrors velocity_m_s{};
  HorizonErrors climb_m_s{};
  HorizonErrors yaw_rate_rad_s{};
};
/// One predicted quantity, with its name on pages and the channel whose model predicts it.
struct Quantity {
  const char* name;
  HorizonErrors Prediction::*member;
  const char* channel;
};
inline constexpr std::array<Quantity, 6> kQuantities{
    {{"roll [rad]", &Prediction::roll_rad, "roll"},
     {"pitch [rad]", &Prediction::pitch_rad, "pitch"},
     {"horizontal velocity [m/s]", &Prediction::velocity_m_s, "translation"},
     {"horizontal position [m]", &Prediction::position_m, "translation"},
     {"climb speed [m/s]", &Prediction::climb_m_s, "climb"},
     {"yaw rate [rad/s]", &Prediction::yaw_rate_rad_s, "yaw_rate"}}};

/// The name of the climb speed where the log has no velocity: the derivative of the measured height.
inline constexpr const char* kClimbByHeight = "climb speed, by the measured height [m/s]";

/// Parts of a flight [s, log's clock] that no fit has used. The log must outlive it.
struct UnseenFlight {
  const logs::FlightLog* log = nullptr;
  std::vector<Range> ranges;
};

Prediction predict(const model::Vehicle& vehicle, const UnseenFlight& flight);

/// Predicts only position and velocity. Precondition: the log has the sticks of roll, pitch and throttle, the attitude,
/// and position or velocity; the vehicle has these three axes.
Prediction predict_motion(const model::Vehicle& vehicle, const UnseenFlight& flight);

/// The error 1 s ahead of one channel: "roll", "pitch", "climb", "yaw_rate", or "translation" for the velocity.
double error_at_1s(const model::Vehicle& vehicle, const UnseenFlight& flight, const std::string& channel);

/// n ln(mean square) of the innovations of a stick axis over the flight: minus twice its log likelihood, up to a
/// constant. Smallest for the vehicle that flew, in a closed loop too. Precondition: not "translation".
double innovations(const model::Vehicle& vehicle, const UnseenFlight& flight, const std::string& channel);

}  // namespace m100::lab::identify
