// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "firmware/model/vehicle.h"
#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/loop/prediction.h"

namespace m100::lab::loop {

// Compares a vehicle file with a flight, for one channel ("roll", "pitch", "climb", "yaw_rate" or "translation").

/// A channel is taken over only if its error 1 s ahead becomes smaller by more than this share. A parameter error whose
/// effect is 0.62 times that of the air has this share: 1 - 1 / sqrt(1 + 0.62^2).
inline constexpr double kMinGain = 0.15;

/// Likelihood ratio (n ln of the mean square of the innovations) that a stick axis needs as well, as identify
/// requires it of an effect.
inline constexpr double kMinLikelihoodRatio = 15.0;

/// Half a tick: our log does not show when between two of our ticks the autopilot took a stick and sent its attitude.
inline constexpr double kTickPhase_s = 0.005;

/// Whether the found model predicts an unseen flight better than the believed one: with an error 1 s ahead that is
/// smaller by kMinGain, and for a stick axis also with innovations better by kMinLikelihoodRatio: in a closed loop the
/// sticks respond to the air, so a wrong model can predict part of the air; innovations do not reward this (the direct
/// method of identification in closed loop). For a stick axis both must hold against five delays within half a tick of
/// the believed one, because at 3 rad/s the effect of a millisecond equals the noise of the air.
bool predicts_better(const model::Vehicle& believed, const model::Vehicle& found, const UnseenFlight& flight,
                     const std::string& channel);

/// The base model and the effects that the vehicle file sets for the channel, to be declared to `identify`: it then
/// finds only effects that the file lacks. Effects of translation that need a thrust set point are left out, because
/// our own logs have none.
std::vector<std::string> declared(const model::Vehicle& vehicle, const std::string& channel);

/// `believed` with this channel taken from `found`; if it is roll or pitch, without the designs.
model::Vehicle with_channel(const model::Vehicle& believed, const model::Vehicle& found, const std::string& channel);

/// Believed and found values of every parameter of the final model, with intervals. A parameter matters if all found
/// values together predict the flight better (predicts_better), its believed value lies outside of the interval by a
/// significant amount, and the believed value predicts at least 1 % worse than the found one, with all other parameters
/// as found. A parameter keeps its believed value, also in `found`, if the prediction does not depend on it (a limit
/// that was never reached), or if it has no valid interval and does not matter by the other two conditions.
/// @param found  the believed vehicle with the channel as identified; undetermined parameters are reset
std::vector<identify::Refitted> believed_and_found(const model::Vehicle& believed,
                                                   const identify::IdentifyResult& result, const std::string& channel,
                                                   const UnseenFlight& flight, model::Vehicle& found);

}  // namespace m100::lab::loop
