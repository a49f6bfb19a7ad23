// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "host_tests/lab/evening/folder.h"

namespace m100::lab::evening {

/// The files that every folder begins with, as shipped.
extern const std::string_view kFlightMap;
extern const std::string_view kHandMap;
extern const std::string_view kFlightFile;

using Command = std::vector<std::string>;

// Numbers of a folder that change how `gains` makes the first vehicle file.
inline constexpr const char* kCalmer = "calmer";      ///< how often the loop swung: the input weight grows for each
inline constexpr const char* kBalanced = "balanced";  ///< the hover's mean sticks are its trims:
inline constexpr const char* kBalanceRoll = "balance_counts.roll";
inline constexpr const char* kBalancePitch = "balance_counts.pitch";
/// How often throttle and yaw were not moved to the end; after the second time climb and yaw rate stay.
inline constexpr const char* kRatesLeft = "rates_left";
inline constexpr const char* kBefore = "course";    ///< the flight of the course with the first vehicle file
inline constexpr const char* kAfter = "corrected";  ///< with the corrected one
inline constexpr const char* kSwung = "calm_law.";  ///< and a flight's name: whether it swung and the calm law flew on
/// Changes a vehicle file as the numbers of the folder say.
void adjust(const Folder& folder, const std::string& vehicle);

/// One step of the evening.
struct Step {
  std::string name;
  bool on_board = false;  ///< a person runs it where the aircraft is; else this program does
  std::string sentence;   ///< what is to be done, in one sentence
  std::vector<std::string> reads;
  std::vector<std::string> makes;
  std::vector<Command> commands;  ///< run inside the folder; "m100-lab" is this program
  /// Looks at what was made and notes its numbers. @returns why the evening does not go on; empty: it does.
  std::function<std::string(Folder&)> judge;
};

/// The whole evening, in its order, with the commands as the settings make them.
std::vector<Step> steps(const Folder& folder);

/// Puts the files there that a person may change before they are used: flight file, course, column maps, first vehicle.
/// What is there already stays.
void lay_out(const Folder& folder);

}  // namespace m100::lab::evening
