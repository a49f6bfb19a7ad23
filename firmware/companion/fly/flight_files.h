// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "firmware/app/config.h"
#include "firmware/companion/files/excitation_file.h"
#include "firmware/companion/files/flight_file.h"
#include "firmware/companion/files/log_file.h"
#include "firmware/companion/fly/flight_model.h"
#include "firmware/companion/fly/fly.h"
#include "firmware/companion/ground_station/guided_mode.h"
#include "firmware/companion/ground_station/return_to_start.h"
#include "firmware/log/flight_log.h"

namespace m100::companion {

/// The operator's files, read and checked before anything flies. Errors: UsageError, or the error of a kind of file.
struct FlightFiles {
  explicit FlightFiles(const FlyOptions& options);

  std::string flight_name;
  std::string flight_text;           ///< empty: no flight file was given
  std::optional<FlightFile> flight;  ///< its mode is that of the next line
  Mode mode = Mode::kField;          ///< that of --mode if given, else of the flight file
  std::string course_name;
  std::string course_text;  ///< empty: hover where the aircraft is
  std::optional<ExcitationFile> excitation;
  std::string excitation_name;
};

/// Whose poses are used: by --pose-from if given, else by the flight file. Errors: FileError.
link::SenderChoice sender_choice(const FlyOptions& options, const FlightFiles& files);

/// `[pose] offset_m` of the flight file; zero without one.
link::LeverArm lever_arm_of(const FlightFiles& files);

/// What a flight begins with, known as soon as poses come. A dry run prepares the same.
struct FlightPreparation {
  /// Waits at most 5 s for the first poses that agree, lays the course from there and checks it. Errors: UsageError,
  /// also if several senders send poses and none was chosen; AnswerIsNo after a signal; CourseError, also if the
  /// course exceeds its limits; FileError if it, or the throttle's excitation, leaves the fence.
  FlightPreparation(PosePort& port, const FlyOptions& options, const FlightFiles& files, const link::LinkConfig& link);

  ref::Waypoint<double> place;  ///< where the aircraft stands
  ref::Waypoint<double> start;  ///< of the course: with --take-off 1.2 m above
  std::unique_ptr<ref::Trajectory<double>> course = std::make_unique<ref::Trajectory<double>>();
  app::FlightConfig config;
};

/// Checks the course before a pose is known: that it can be read, keeps its limits, stays inside the sides of the
/// fence, and inside its heights from at least one start height. Errors: CourseError, FileError.
/// @returns the start heights [m], in the world of the pose, from which it stays inside; all without a flight file.
Range check_offsets(const FlightFiles& files);

/// How the flight takes goals; nullopt: it takes none, because there is neither a key nor --set-points-from, or no
/// flight file, or because it flies an excitation.
std::optional<GoalSettings> goal_settings(const FlyOptions& options, const FlightFiles& files);

/// What the flight does on a low battery.
ReturnSettings home_settings(const FlightFiles& files);

/// Begins the log with the texts (files, options) that `m100 replay` needs besides the records. @returns null: no log
/// was requested. Errors: UsageError.
log::FlightLogWriter* begin_log(std::optional<LogFile>& file, const FlyOptions& options, const FlightModel& model,
                                const FlightFiles& files, const FlightPreparation& prepared, core::TimePoint now);

}  // namespace m100::companion
