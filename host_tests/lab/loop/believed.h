// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "firmware/model/vehicle.h"
#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/loop/prediction.h"

namespace m100::lab::loop {

// What a vehicle file believes of one channel ("roll", "pitch", "climb", "yaw_rate" or "translation"), set against what
// a flight shows.

/// By how much smaller the error 1 s ahead must be for a channel to be taken over: near the floor that the air leaves,
/// that is a parameter error worth half of the floor.
inline constexpr double kLeastGain = 0.15;

/// And by how much likelier a stick axis must make the flight (n ln of the mean square of its innovations): as identify
/// asks of an effect.
inline constexpr double kLeastLikelier = 15.0;

/// Half a tick: when between two of our ticks the autopilot took a stick and sent its attitude, our log does not say.
inline constexpr double kTickPhase_s = 0.005;

/// Whether what was found predicts an unseen flight better than what was believed, a stick axis wherever within half a
/// tick the believed delay lies: at 3 rad/s a millisecond is worth what the air leaves. Better means 1 s ahead, and for
/// a stick axis by its innovations too: in a closed loop the sticks answer the air, so that a model which is wrong in
/// the right way foretells some of it; innovations do not reward that (the direct method of identification in closed
/// loop).
bool predicts_better(const model::Vehicle& believed, const model::Vehicle& found, const Unseen& flight,
                     const std::string& channel);

/// Everything that the file says of the channel, as a declaration for `identify`: only what the file lacks can then be
/// called missing. Effects of translation that our own logs cannot show (they have no thrust set point) are left out.
std::vector<std::string> declared(const model::Vehicle& vehicle, const std::string& channel);

/// `believed` with the channel as `found` has it.
model::Vehicle with_channel(const model::Vehicle& believed, const model::Vehicle& found, const std::string& channel);

/// Believed and found values of every parameter of the final model, with intervals. A parameter matters where all found
/// ones together predict the flight better (predicts_better), and its believed value lies outside of the interval by
/// more than what means something and predicts at least 1 % worse than the found one does beside all other found ones.
/// A number on which the prediction does not depend (a limit that was never reached) was not found: it stays as it was
/// believed, in `found` too.
/// @param found  the believed vehicle with the channel as identified; undetermined numbers are put back
std::vector<identify::Refitted> believed_and_found(const model::Vehicle& believed,
                                                   const identify::IdentifyResult& result, const std::string& channel,
                                                   const Unseen& flight, model::Vehicle& found);

}  // namespace m100::lab::loop
