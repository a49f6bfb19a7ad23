// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/evening/folder.h"

// The checks after each step. Each function reads the step's result in the folder and returns in one sentence why the
// evening cannot continue; empty: it continues.
namespace m100::lab::evening {

std::string check_probe(const Folder& folder, const std::string& result);
/// The log must not be one of m100 fly; roll and pitch sticks must have moved by 60 counts to both sides.
std::string check_recording(const Folder& folder, const std::string& result);
/// Checks the results of identification, one for each axis: the fit to the validation part must be at least 50 %.
/// Records the error, delay and trim of each axis under `name`.
std::string check_identification(Folder& folder, const std::vector<std::string>& answers, const std::string& name);
std::string check_margins(const Folder& folder, const std::string& result);
std::string check_handshake(const Folder& folder, const std::string& result);
/// Control must have been obtained and given back, and the failsafe must not have left normal flight before.
std::string check_flight(const Folder& folder, const std::string& result);
/// Checks the flight of NAME.json and NAME.ulg, records the mean sticks after its first 5 s (kTrimRoll, kTrimPitch),
/// and refuses it if the loop oscillates, by the log or by the result of m100 fly. The step `gains` must then be done
/// again with a larger input weight (kWeightIncreases), at most twice.
std::string check_hover(Folder& folder, const std::string& name);
/// Checks a flight of the course (NAME.json and NAME.ulg) and records its errors (record_errors()). If the first flight
/// before the correction oscillates, `gains` is to be done again with a larger input weight, at most twice.
std::string check_course(Folder& folder, const std::string& name);
/// Checks the excitation of roll and pitch. If it oscillated or did not come to rest, a larger input weight is
/// requested. If the excitation itself ended it early, for example at its fence, the mean sticks of the hover become
/// the trims (kTrimmed), once; not if the failsafe ended it or control was lost. In both cases `gains` and the flights
/// made with it must be done again.
std::string check_excitation(Folder& folder, const std::string& result);
/// Checks the movements of throttle and yaw: a first flight that does not reach their end must be flown again; a second
/// one passes, and kRatesNotFlown records it.
std::string check_rates_excitation(Folder& folder, const std::string& result);

}  // namespace m100::lab::evening
