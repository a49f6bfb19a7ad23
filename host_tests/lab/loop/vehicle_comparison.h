// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "firmware/model/vehicle.h"
#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/identify/prediction.h"

namespace m100::lab::loop {

// Compares a vehicle file with a flight, for one channel ("roll", "pitch", "climb", "yaw_rate" or "translation").

/// A channel is taken over only if its error 1 s ahead becomes smaller by more than this fraction.
inline constexpr double kMinGain = 0.15;

/// Likelihood ratio (n ln of the mean square of the innovations) that a stick axis needs as well to be taken over.
inline constexpr double kMinLikelihoodRatio = 15.0;

/// Half a tick. Our log does not show when, between two ticks, the autopilot took a stick and sent its attitude.
inline constexpr double kTickPhase_s = 0.005;

/// Whether the found model predicts an unseen flight better than the believed one: its error 1 s ahead must be smaller
/// by kMinGain. For a stick axis its innovations must also be better by kMinLikelihoodRatio, because in a closed loop
/// the sticks respond to the air and a wrong model can predict part of it. Both must then hold against believed delays
/// within half a tick, too.
bool predicts_better(const model::Vehicle& believed, const model::Vehicle& found, const identify::UnseenFlight& flight,
                     const std::string& channel);

/// The base model and the effects that the vehicle file sets for the channel, to be declared to `identify`: it then
/// finds only effects that the file lacks. Effects of translation that need a thrust set point are left out, because
/// our own logs have none.
std::vector<std::string> declared(const model::Vehicle& vehicle, const std::string& channel);

/// `believed` with this channel taken from `found`; if it is roll or pitch, without the designs.
model::Vehicle with_channel(const model::Vehicle& believed, const model::Vehicle& found, const std::string& channel);

/// Believed and found values of every parameter of the final model, with intervals. A parameter matters if the found
/// model predicts the flight better, and its believed value lies outside of the interval and predicts at least 1 %
/// worse. A parameter that the flight does not determine keeps its believed value, also in `found`.
/// @param found  the believed vehicle with the channel as identified; undetermined parameters are reset
std::vector<identify::Refitted> believed_and_found(const model::Vehicle& believed,
                                                   const identify::IdentifyResult& result, const std::string& channel,
                                                   const identify::UnseenFlight& flight, model::Vehicle& found);

}  // namespace m100::lab::loop
