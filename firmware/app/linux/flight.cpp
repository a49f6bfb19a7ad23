// SPDX-License-Identifier: BSD-3-Clause
// m100 fly: the flight controller on a course, from the first pose to the hand-over.
#include <sched.h>
#include <sys/mman.h>

#include <iostream>
#include <memory>
#include <optional>
#include <sstream>

#include "firmware/app/course.h"
#include "firmware/app/farewell.h"
#include "firmware/app/flight_controller.h"
#include "firmware/app/linux/flight_model.h"
#include "firmware/app/linux/fly.h"
#include "firmware/app/linux/link_report.h"
#include "firmware/app/linux/log_file.h"
#include "firmware/app/linux/pilotage.h"
#include "firmware/app/linux/subcommands.h"
#include "firmware/app/replay.h"
#include "firmware/vrc/command_map.h"

namespace m100::app {
namespace {

using Controller = FlightController<double>;
constexpr int kPriority = 50;  ///< of SCHED_FIFO, where it is granted
constexpr core::Duration kPosePatience = std::chrono::seconds(5);

/// Where the aircraft stands: the first pose.
ref::Waypoint<double> first_pose(hal::SerialPort& port, std::uint32_t baud) {
  PoseLink link(port, baud);
  TickClock clock;
  for (core::TimePoint now = clock.now(); now.time_since_epoch() < kPosePatience && !stop_asked(); now = clock.next()) {
    if (const core::Expected<PoseSample> sample = link.receive(now)) {
      const std::array<float, 4>& q = sample->message.rotation_wb;
      const core::Quaternion<double> rotation{static_cast<double>(q[0]), static_cast<double>(q[1]),
                                              static_cast<double>(q[2]), static_cast<double>(q[3])};
      const std::array<float, 3>& p = sample->message.position_w_m;
      ref::Waypoint<double> start;
      start.position_w_m = {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
      start.yaw_rad = core::euler_of(rotation).yaw_rad;
      return start;
    }
  }
  if (stop_asked()) {
    throw CLI::RuntimeError(kAnswerIsNo);
  }
  throw UsageError(port.path() + ": no pose within " + std::to_string(kPosePatience.count() / 1000000) +
                   " s (m100 expects its own message, protocol/pose_message.h)");
}

void write_notes(log::FlightLog& log, const FlyOptions& options, const FlightModel& model, const std::string& course,
                 const ref::Waypoint<double>& start, const FlightConfig& config, core::TimePoint now) {
  std::ostringstream place;
  place.precision(17);
  place << start.position_w_m.x() << " " << start.position_w_m.y() << " " << start.position_w_m.z() << " "
        << start.yaw_rad;
  const std::string where = place.str();
  const std::string channel = options.channel + (options.paper_100_hz ? " paper_100_hz" : "");
  const std::string link = link_note(config);
  const std::array notes{log::Note{kVehicleNote, model.vehicle_text()},
                         log::Note{kTablesNote, model.table_bytes()},
                         log::Note{kCourseNote, course},
                         log::Note{kStartNote, where},
                         log::Note{kChannelNote, channel},
                         log::Note{kLinkNote, link}};
  if (log.begin(now, notes) != core::Status::kOk) {
    throw UsageError(options.log + ": the gain tables are too large for the log's ring");
  }
}

/// What an assertion handler can reach.
hal::SerialPort* farewell_port = nullptr;
const Farewell* farewell = nullptr;

void say_farewell(const char* file, int line) {
  (void)farewell_port->write(farewell->bytes());
  std::cerr << "m100: broken invariant at " << file << ":" << line << "; control was released\n";
  std::_Exit(kAnswerIsNo);
}

ChannelCommand neutral_of(const FlyOptions& options, const model::Vehicle& vehicle) {
  return options.channel == "movement" ? ChannelCommand(ctl::Command<double>{})
                                       : ChannelCommand(vrc::CommandMap(vehicle).neutral());
}

void ask_for_real_time() {
  const sched_param priority{.sched_priority = kPriority};
  if (sched_setscheduler(0, SCHED_FIFO, &priority) != 0 || mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
    std::cout << "no real-time rights; m100 doctor tells how to get them\n";
  }
}

std::string to_json(const FlyOptions& options, const Pilotage& pilotage, const Controller& controller,
                    std::uint32_t stalls) {
  const AuthorityView& authority = controller.link().authority();
  const est::Estimate<double>& estimate = controller.estimate();
  std::ostringstream out;
  out << "{\"channel\":" << quoted(options.channel) << ",\"baud\":" << options.baud
      << ",\"obtained\":" << (pilotage.flew() ? "true" : "false")
      << ",\"released\":" << (pilotage.given_back() ? "true" : "false")
      << ",\"last_stage\":" << quoted(safety::name(authority.stage))
      << ",\"last_reason\":" << quoted(safety::name(authority.reason)) << ",\"stalls\":" << stalls
      << ",\"position_m\":[" << estimate.x.position_m << "," << estimate.y.position_m << "," << estimate.height_m
      << "],\"health\":" << to_json(controller.link().health()) << "}";
  return out.str();
}

}  // namespace

bool fly_course(const FlyOptions& options, const LinkConfig& link, hal::SerialPort& port) {
  if (options.pose_port.empty() || options.vehicle.empty() || options.gains.empty()) {
    throw UsageError("fly: needs --pose-port, --vehicle and --gains (or --dry-run)");
  }
  const FlightModel model(options.vehicle, options.gains);
  const std::string course_text = options.course.empty() ? "" : read_file(options.course);
  hal::SerialPort pose_port(options.pose_port, options.pose_baud);
  open_or_explain(pose_port);
  const ref::Waypoint<double> start = first_pose(pose_port, options.pose_baud);
  const auto trajectory = std::make_unique<ref::Trajectory<double>>();
  lay_course(course_text, start, *trajectory, options.course);

  FlightConfig config;
  config.link = link;
  config.pose_baud = options.pose_baud;
  TickClock clock;
  std::optional<LogFile> log;
  if (!options.log.empty()) {
    log.emplace(options.log);
    write_notes(log->log(), options, model, course_text, start, config, clock.now());
    log->start();
  }
  const auto controller = std::make_unique<Controller>(model.vehicle(), model.tables(), config, port, pose_port,
                                                       *trajectory, log ? &log->log() : nullptr);
  const Farewell last_words(neutral_of(options, model.vehicle()), link.encrypt_commands ? link.cipher : nullptr);
  farewell = &last_words;
  farewell_port = &port;
  const core::AssertionHandler former = core::set_assertion_handler(&say_farewell);
  ask_for_real_time();
  Pilotage pilotage(options, *controller);
  constexpr core::Duration kHealthPeriod = std::chrono::seconds(1);
  core::TimePoint health_logged_at{};
  HealthText health_text{};
  for (core::TimePoint now = clock.now();; now = clock.next()) {
    (void)controller->tick(now);  // what became of the command stands in the log
    if (log && now - health_logged_at >= kHealthPeriod) {
      log->log().append(now, health_line(controller->link().health(), health_text));
      health_logged_at = now;
    }
    if (!pilotage.tick(now)) {
      break;
    }
  }
  core::set_assertion_handler(former);
  print(std::cout, controller->link().health());
  if (!options.json.empty()) {
    write_file(options.json, to_json(options, pilotage, *controller, clock.stalls()));
  }
  return pilotage.given_back();
}

}  // namespace m100::app
