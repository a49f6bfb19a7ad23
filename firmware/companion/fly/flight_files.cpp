// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/flight_files.h"

#include <algorithm>
#include <deque>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "firmware/companion/files/course/course.h"
#include "firmware/companion/files/flight_limits.h"
#include "firmware/companion/files/text/printable.h"
#include "firmware/companion/fly/start_position.h"
#include "firmware/companion/ground_station/guided_mode.h"
#include "firmware/companion/replay/replay.h"
#include "firmware/companion/subcommands.h"
#include "firmware/companion/version.h"
#include "firmware/link/pose/pose_link.h"

namespace m100::companion {
namespace {

constexpr core::Duration kPosePatience = std::chrono::seconds(5);
constexpr core::Duration kRatesKnown = std::chrono::seconds(1);    ///< until the rates of two senders can be named
constexpr core::Duration kLooks = std::chrono::milliseconds(300);  ///< wait for a second sender: nine poses of 30 Hz
constexpr double kEverywhere_m = 1e9;

/// Lowest (at most 0) and highest (at least 0) height of a course that starts at height 0.
Range heights_over_start(const ref::Trajectory<double>& course, const std::vector<CoursePiece>& pieces) {
  Range heights_m;
  for_each_sample(course, pieces, [&](const CoursePiece&, core::Duration, const ref::Motion& motion) {
    heights_m = {std::min(heights_m.low, motion[2][0]), std::max(heights_m.high, motion[2][0])};
  });
  return heights_m;
}

CourseLimits limits_of_course(const FlightFiles& files) {
  return files.flight ? course_limits_of(*files.flight) : CourseLimits{};
}

/// Refuses an excitation of the throttle that may leave the heights of the fence: the geofence limiter brakes only
/// before the sides of the fence.
void expect_height_for(const FlightFiles& files, const ref::Waypoint<double>& start) {
  if (!files.excitation || !files.excitation->moves(ctl::ExcitedStick::kThrottle)) {
    return;
  }
  const double distance_m = files.excitation->limits[static_cast<std::size_t>(ctl::ExcitedStick::kThrottle)].distance;
  const double height_m = start.position_w_m.z();
  const Range fence_m = files.flight->fence_z_m;
  if (height_m - distance_m < fence_m.low || height_m + distance_m > fence_m.high) {
    throw FileError(files.excitation_name + ": its throttle may take the aircraft " + std::to_string(distance_m) +
                    " m up and down; from a height of " + std::to_string(height_m) + " m that leaves " +
                    files.flight_name + "'s fence.z_m");
  }
}

/// Refuses an excitation of roll or pitch that may move farther than the nearest side of the fence is from the start:
/// it would be aborted in flight.
void expect_room_for(const FlightFiles& files) {
  if (!files.flight) {
    return;
  }
  const FlightFile& flight = *files.flight;
  const double side_m =
      std::min({-flight.fence_x_m.low, flight.fence_x_m.high, -flight.fence_y_m.low, flight.fence_y_m.high});
  for (const ctl::ExcitedStick axis : {ctl::ExcitedStick::kRoll, ctl::ExcitedStick::kPitch}) {
    const double distance_m = files.excitation->limits[static_cast<std::size_t>(axis)].distance;
    if (files.excitation->moves(axis) && distance_m > side_m) {
      std::ostringstream said;
      said << files.excitation_name << ": its " << name(axis) << " may take the aircraft " << distance_m
           << " m from the start, but " << files.flight_name << "'s fence ends after " << side_m
           << " m: make the file with an m100-lab excite --fence that is one or two metres smaller";
      throw FileError(said.str());
    }
  }
}

/// Builds the course; refuses a course file without a piece, which would be a hover that the operator did not order.
std::vector<CoursePiece> lay(const FlightFiles& files, const ref::Waypoint<double>& start,
                             ref::Trajectory<double>& course) {
  std::vector<CoursePiece> pieces = parse_course(files.course_text, start, course, files.course_name);
  if (pieces.empty() && !files.course_name.empty()) {
    throw CourseError(files.course_name + ": has no piece; without --course the aircraft hovers where it is");
  }
  return pieces;
}

/// Why the poses that came within kPosePatience do not show where the aircraft stands.
std::string why_no_start(const StartPosition& place, const link::PoseLink& link, const PosePort& port,
                         const ExchangedPorts& exchanged) {
  if (place.disagrees()) {
    return "its poses do not agree on where the aircraft stands: of nine in a row, more than half lie 0.3 m or farther "
           "from their median; hold it still, and check the source of pose";
  }
  const std::string patience = " within " + std::to_string(kPosePatience.count() / 1000000) + " s; ";
  if (place.poses() == 0) {
    return "no pose" + patience + why_no_pose(link, port, exchanged);
  }
  const std::string refusals = describe_refusals(link.stats());
  return "only " + std::to_string(place.poses()) + " poses" + patience +
         (refusals.empty() ? std::to_string(StartPosition::kPoses) +
                                 " are needed to know where the aircraft stands: check the rate of the source of pose"
                           : "refused: " + refusals);
}

}  // namespace

FlightFiles::FlightFiles(const FlyOptions& options) : flight_name(options.flight), course_name(options.course) {
  if (!options.flight.empty()) {
    flight_text = read_file(options.flight);
    flight = parse_flight(flight_text, flight_name);
    mode = options.mode.empty() ? flight->mode : mode_of(options.mode, "--mode");
    flight->mode = mode;
  } else if (!options.mode.empty()) {
    mode = mode_of(options.mode, "--mode");
  }
  course_text = options.course.empty() ? "" : read_file(options.course);
  if (!options.excite.empty()) {
    excitation_name = options.excite;
    excitation = parse_excitation(read_file(options.excite), options.excite);
    expect_room_for(*this);
  }
}

link::SenderChoice sender_choice(const FlyOptions& options, const FlightFiles& files) {
  const link::SenderChoice chosen = choice_of(options.pose);
  return chosen.is_made() || !files.flight ? chosen : files.flight->pose_from;
}

link::LeverArm lever_arm_of(const FlightFiles& files) {
  return files.flight ? files.flight->pose_offset_m : link::LeverArm{};
}

Range check_offsets(const FlightFiles& files) {
  const auto course = std::make_unique<ref::Trajectory<double>>();
  ref::Waypoint<double> start;
  const std::vector<CoursePiece> pieces = lay(files, start, *course);
  validate_course(*course, pieces, start, limits_of_course(files), files.course_name);
  if (!files.flight) {
    return {-kEverywhere_m, kEverywhere_m};
  }
  const Range heights_m = heights_over_start(*course, pieces);
  const Range fence_m = files.flight->fence_z_m;
  start.position_w_m.z() = fence_m.low - heights_m.low;  // the lowest start for which the course stays inside
  validate_inside_fence(*files.flight, start, *course, lay(files, start, *course), files.course_name);
  return {start.position_w_m.z(), fence_m.high - heights_m.high};
}

std::optional<GoalSettings> goal_settings(const FlyOptions& options, const FlightFiles& files) {
  const bool takes_goals = !options.pose.key_file.empty() || !options.pose.set_points_from.empty();
  if (!takes_goals || !files.flight || files.excitation) {
    return {};
  }
  return GoalSettings{.limits = goal_limits_of(*files.flight),
                      .stream = stream_limits_of(*files.flight),
                      .only = unsigned_sender(options.pose)};
}

ReturnSettings home_settings(const FlightFiles& files) {
  return files.flight
             ? ReturnSettings{.low_percent = files.flight->battery_low_percent, .limits = goal_limits_of(*files.flight)}
             : ReturnSettings{};
}

namespace {

ref::Waypoint<double> find_start_position(PosePort& port, const FlyOptions& options, const FlightFiles& files) {
  ExchangedPorts exchanged;
  link::PoseLink link(port.line(), port.baud(), &exchanged, sender_choice(options, files),
                      {.offset_b_m = lever_arm_of(files)});
  std::optional<ref::Waypoint<double>> start;
  TickClock clock(port.clock_port(), [&] { port.mark_arrived(); });
  StartPosition place;
  for (core::TimePoint now = clock.now(); now.time_since_epoch() < kPosePatience && !stop_requested();
       now = clock.next()) {
    port.tick();
    if (const core::Expected<core::Pose<double>> pose = link.receive(now)) {
      start = start ? start : place.add(*pose);
    }
    const bool has_rival = link.rival(now) != nullptr;
    if (has_rival && now.time_since_epoch() >= kRatesKnown) {
      throw UsageError(port.name() + ": poses come from several senders: " + describe(link.senders()) +
                       ": choose one with --pose-from SYS:COMP, or with 'from' in the flight file's [pose]");
    }
    if (start && !has_rival && now.time_since_epoch() >= kLooks) {
      return *start;
    }
  }
  if (stop_requested()) {
    throw AnswerIsNo();
  }
  const std::string why = port.name() + ": " + why_no_start(place, link, port, exchanged);
  if (link.stats().last_fault == link::PoseFault::kQuality) {  // the input is right: the source itself has failed
    std::cerr << "m100: control is not asked for: " << printable(why) << "\n";
    throw AnswerIsNo();
  }
  throw UsageError(why);
}

/// Where a take-off from this place by the autopilot's own task ends (protocol, 6.3: "about 1.2 m").
ref::Waypoint<double> takeoff_end(ref::Waypoint<double> place) {
  constexpr double kTakeOffHeight_m = 1.2;
  place.position_w_m.z() += kTakeOffHeight_m;
  return place;
}

void parse_and_validate(const FlightFiles& files, const ref::Waypoint<double>& start, ref::Trajectory<double>& course) {
  const std::vector<CoursePiece> pieces = lay(files, start, course);
  validate_course(course, pieces, start, limits_of_course(files), files.course_name);
  if (files.flight) {
    validate_inside_fence(*files.flight, start, course, pieces, files.course_name);
    expect_height_for(files, start);
  }
}

app::FlightConfig flight_config(const FlyOptions& options, const FlightFiles& files, const ref::Waypoint<double>& start,
                                const link::LinkConfig& link) {
  app::FlightConfig config;
  config.link = link;
  config.pose_baud = hal::is_udp(options.pose.port) ? 0 : options.pose.baud;
  config.pose_from = sender_choice(options, files);
  config.law = mpc::law_of(options.law).value_or(mpc::Law::kMpc);
  for (const std::string& check : options.disabled_checks) {
    config.disabled_checks = static_cast<est::CheckSet>(
        config.disabled_checks | set_of(est::check_of(check).value_or(est::ConsistencyCheck::kNone)));
  }
  if (files.flight) {
    config.limits = limits_of(*files.flight);
    config.fence = fence_of(*files.flight, start);
    config.pose_sigma_m = files.flight->pose_sigma_m;
  }
  config.pose_offset_b_m = lever_arm_of(files);
  if (files.excitation) {
    config.excitation = files.excitation->plan();
  }
  return config;
}

void write_notes(log::FlightLogWriter& log, const FlyOptions& options, const FlightModel& model,
                 const FlightFiles& files, const ref::Waypoint<double>& start, const app::FlightConfig& config,
                 core::TimePoint now) {
  std::deque<std::string> texts;  // keeps its elements in place: a note is a view
  std::vector<log::Note> notes;
  const auto add = [&](const char* key, std::string text) {
    notes.push_back({key, texts.emplace_back(std::move(text))});
  };
  std::ostringstream place;
  place.precision(17);
  place << start.position_w_m.x() << " " << start.position_w_m.y() << " " << start.position_w_m.z() << " "
        << start.yaw_rad;
  add(kVehicleNote, model.vehicle_text());
  add(kCourseNote, files.course_text);
  add(kStartNote, place.str());
  add(kChannelNote, options.channel + (options.paper_100_hz ? " paper_100_hz" : ""));
  add(kLinkNote, link_note(config));
  add(kVersionNote, version());
  const bool holds_tables = add_table_notes(model.table_bytes(), notes);
  if (files.flight) {
    add(kFlightNote, files.flight_text);
    add(kModeNote, std::string(name(files.flight->mode)));
  }
  if (files.excitation) {
    add(kExcitationNote, note_of(*files.excitation, files.excitation_name));
  }
  if (const std::optional<GoalSettings> goals = goal_settings(options, files); goals && !options.dry_run) {
    add(kGoalsNote, goals_note(*goals));
  }
  options.dry_run ? add(kDryRunNote, "nothing was sent") : add(kHomeNote, home_note(home_settings(files)));
  if (!holds_tables || log.begin(now, notes) != core::Status::kOk) {
    throw UsageError(options.log + ": vehicle, gain tables, course and flight file are together too large for a log");
  }
}

}  // namespace

FlightPreparation::FlightPreparation(PosePort& port, const FlyOptions& options, const FlightFiles& files,
                                     const link::LinkConfig& link)
    : place(find_start_position(port, options, files)), start(options.take_off ? takeoff_end(place) : place) {
  parse_and_validate(files, start, *course);
  config = flight_config(options, files, start, link);
}

log::FlightLogWriter* begin_log(std::optional<LogFile>& file, const FlyOptions& options, const FlightModel& model,
                                const FlightFiles& files, const FlightPreparation& prepared, core::TimePoint now) {
  if (options.log.empty()) {
    return nullptr;
  }
  file.emplace(options.log);
  write_notes(file->log(), options, model, files, prepared.start, prepared.config, now);
  file->start();
  return &file->log();
}

}  // namespace m100::companion
