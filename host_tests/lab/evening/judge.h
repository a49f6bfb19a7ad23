// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/evening/folder.h"

// What must hold after a step. Each function reads the step's result in the folder and returns why the evening does not
// go on, in one sentence; empty: it goes on.
namespace m100::lab::evening {

std::string judge_probe(const Folder& folder, const std::string& result);
std::string judge_recording(const Folder& folder, const std::string& result);
/// The answers of identification, one for each axis: the model must explain the validation part.
/// Notes the error of each axis under `name`.
std::string judge_identification(Folder& folder, const std::vector<std::string>& answers, const std::string& name);
std::string judge_margins(const Folder& folder, const std::string& result);
std::string judge_handshake(const Folder& folder, const std::string& result);
std::string judge_flight(const Folder& folder, const std::string& result);
/// The same for NAME.json and NAME.ulg; a loop that swings (campaign::Swing, or noticed in flight) does not pass. Then
/// kCalmer counts up and `gains` is to be done again, with calmer weights; after the second time nothing is changed any
/// more.
std::string judge_hover(Folder& folder, const std::string& name);
/// The same for NAME.json and NAME.ulg, and notes the errors of note_errors().
/// @param vehicle file that flew.
std::string judge_course(Folder& folder, const std::string& name, const std::string& vehicle);
/// An excitation that did not come to rest makes the weights calmer, as in a hover that swings; one that went too far,
/// by distance, tilt or speed, sets kBalanced. Either way `gains` is to be done again, and what was flown with it.
std::string judge_excitation(Folder& folder, const std::string& result);
/// The movements of throttle and yaw: the first flight that does not reach their end is to be flown again, the second
/// passes with kRatesLeft noted.
std::string judge_rates_excitation(Folder& folder, const std::string& result);

}  // namespace m100::lab::evening
