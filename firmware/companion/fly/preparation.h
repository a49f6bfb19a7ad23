// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "firmware/app/config.h"
#include "firmware/companion/files/excitation_file.h"
#include "firmware/companion/files/flight_file.h"
#include "firmware/companion/fly/flight_model.h"
#include "firmware/companion/fly/fly.h"
#include "firmware/companion/room/homeward.h"
#include "firmware/log/flight_log.h"

namespace m100::companion {

/// What the operator's files say, read and checked before anything flies. Errors: UsageError, FlightFileError.
struct Orders {
  explicit Orders(const FlyOptions& options);

  std::string flight_name;
  std::string flight_text;           ///< empty: no flight file was given
  std::optional<FlightFile> flight;  ///< with --mode's tuning
  Mode mode = Mode::kField;          ///< of the flight file, or --mode
  std::string course_name;
  std::string course_text;  ///< empty: hover where the aircraft is
  std::optional<ExcitationFile> excitation;
  std::string excitation_name;
};

/// Where the aircraft stands: the first poses that agree, waited for 5 s. Errors: UsageError; CLI::RuntimeError after a
/// signal.
ref::Waypoint<double> first_pose(PosePort& port);

/// Where the autopilot's take-off ends that begins here (protocol, 6.3: "about 1.2 m").
ref::Waypoint<double> above(ref::Waypoint<double> place);

/// The course from where the flight starts. Errors: CourseError, also where it asks for more than its limits;
/// FlightFileError where it leaves the fence.
void lay_and_check(const Orders& orders, const ref::Waypoint<double>& start, ref::Trajectory<double>& course);

/// The same without a pose: the course can be read, stays inside the fence's sides from wherever it starts, and inside
/// its heights from some. Errors as above.
/// @returns the heights of a start, in the world of the pose, from which it does [m]; all where there is no flight
/// file.
Range check_offsets(const Orders& orders);

/// How fast the ways to goals are; nothing: this flight takes none, because nobody has a key or an excitation flies.
std::optional<ref::SpeedLimits> goal_limits(const FlyOptions& options, const Orders& orders);

/// What a low battery makes of the flight.
HomeSettings home_settings(const Orders& orders);

app::FlightConfig flight_config(const FlyOptions& options, const Orders& orders, const ref::Waypoint<double>& start,
                                const link::LinkConfig& link);

/// Begins the log with what `m100 replay` must know beside the records. Errors: UsageError.
void write_notes(log::FlightLogWriter& log, const FlyOptions& options, const FlightModel& model, const Orders& orders,
                 const ref::Waypoint<double>& start, const app::FlightConfig& config, core::TimePoint now);

}  // namespace m100::companion
