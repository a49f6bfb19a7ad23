// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "host_tests/lab/evening/folder.h"

namespace m100::lab::evening {

/// Texts of four of the files that every new folder starts with (write_initial_files()).
extern const std::string_view kFlightMap;
extern const std::string_view kClimbMap;
extern const std::string_view kHandMap;
extern const std::string_view kFlightFile;

using Command = std::vector<std::string>;

// Numbers of a folder that change how `gains` makes the first vehicle file.
inline constexpr const char* kWeightIncreases =
    "calmer";  ///< how often the input weight has grown, because the loop oscillated or did not come to rest
inline constexpr const char* kTrimmed = "balanced";  ///< if recorded, the trims are the hover's mean sticks, below
inline constexpr const char* kTrimRoll = "trim_counts.roll";
inline constexpr const char* kTrimPitch = "trim_counts.pitch";
/// How often the flight of throttle and yaw did not reach its end; after two, climb and yaw rate are not identified.
inline constexpr const char* kRatesNotFlown = "rates_left";
inline constexpr const char* kBefore = "course";    ///< the flight of the course with the first vehicle file
inline constexpr const char* kAfter = "corrected";  ///< the flight of the course with the corrected vehicle file
inline constexpr const char* kFallbackLaw =
    "fallback_law.";  ///< before a flight's name; 1: it oscillated, and the fallback law took over; 0: it did not

/// One step of the evening.
struct Step {
  std::string name;
  bool on_board = false;  ///< it runs on the board, by a person or by ssh; otherwise on this machine
  std::string sentence;   ///< the task, in one sentence
  std::vector<std::string> reads;
  std::vector<std::string> makes;
  std::vector<Command> commands;  ///< run inside the folder: m100, m100-lab (this program), or a word of Evening::run()
  /// Checks the step's files and records their numbers. @returns why the evening cannot continue; empty: it continues.
  std::function<std::string(Folder&)> evaluate;
};

/// All steps of the evening in their order, with their commands filled in from the settings.
std::vector<Step> steps(const Folder& folder);

}  // namespace m100::lab::evening
