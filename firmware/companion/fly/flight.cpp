// SPDX-License-Identifier: BSD-3-Clause
// m100 fly: flies a course with the flight controller, from the first pose to the handover.
#include "firmware/companion/fly/flight.h"
#include "firmware/companion/files/text/json.h"
#include "firmware/companion/files/text/printable.h"

#include <sched.h>
#include <sys/mman.h>

#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <utility>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/backup/backup_process.h"
#include "firmware/companion/files/log_file.h"
#include "firmware/companion/fly/flight_files.h"
#include "firmware/companion/fly/flight_model.h"
#include "firmware/companion/fly/flight_result.h"
#include "firmware/companion/fly/flight_sequencer.h"
#include "firmware/companion/fly/monitor/stall_monitor.h"
#include "firmware/companion/ground_station/ground_station_commands.h"
#include "firmware/companion/ground_station/telemetry_stream.h"
#include "firmware/companion/operator/line_writer.h"
#include "firmware/companion/operator/link_report.h"
#include "firmware/companion/operator/operator_log.h"
#include "firmware/companion/operator/operator_messages.h"
#include "firmware/companion/operator/terminal.h"
#include "firmware/companion/preflight/model_findings.h"
#include "firmware/companion/subcommands.h"
#include "firmware/link/release_sequence.h"
#include "firmware/log/flight_log.h"
#include "firmware/vrc/command_map.h"
#include "hal/linux/service_watchdog.h"

namespace m100::companion {
namespace {

/// Tells the operator if the vehicle file has no [design].
void say_design(const model::Vehicle& vehicle) {
  if (!vehicle.design.exists()) {
    print_line("the vehicle file has no [design]: the identified axes and [mpc] fly; m100-lab gains --tune makes one");
  }
}

using Controller = app::FlightController<double>;
constexpr int kPriority = 50;  ///< of SCHED_FIFO, if it is granted
/// Largest distance from the beginning of the course at which control is taken. A pilot's hover wanders by a metre;
/// from farther away the law would fly a way that the operator did not order.
constexpr double kReach_m = 1.5;

// An assertion handler can only use globals.
hal::SerialPort* farewell_port = nullptr;
const link::ReleaseSequence* release_sequence = nullptr;
const link::AuthorityView* farewell_authority = nullptr;

void send_release_sequence(const char* file, int line) {
  // The neutral command is a control command: it must not be sent when the pilot has control (promise R4).
  (void)farewell_port->write(farewell_authority->in_control ? release_sequence->bytes()
                                                            : release_sequence->release_only());
  std::cerr << "m100: broken invariant at " << file << ":" << line << "; control was released\n";
  std::_Exit(kAnswerIsNo);
}

/// Makes a broken invariant send the release sequence from now on. @returns the former handler.
core::AssertionHandler release_on_assertion(const link::ReleaseSequence& last_words, hal::SerialPort& port,
                                            const link::AuthorityView& authority) {
  release_sequence = &last_words;
  farewell_port = &port;
  farewell_authority = &authority;
  return core::set_assertion_handler(&send_release_sequence);
}

/// Whether the excitation was flown to its end, if there is one.
bool is_excited(const FlightFiles& files, const Controller& controller) {
  return !files.excitation || controller.excitation().state() == ctl::Excitation<double>::State::kOver;
}

FlightFiles files_of(const FlyOptions& options) {
  if (options.pose.port.empty() || options.vehicle.empty() || options.gains.empty() || options.flight.empty()) {
    throw UsageError("fly: needs --pose-port, --vehicle, --gains and --flight (or --dry-run)");
  }
  return FlightFiles(options);
}

FlightRequest request_of(const FlyOptions& options, const FlightFiles& files, const FlightPreparation& prepared) {
  return {.take_control = options.take_control,
          .hold_s = options.hold_s,
          .once = options.once,
          .take_off = options.take_off,
          .land = options.land,
          .course_start_w_m = prepared.start.position_w_m,
          .takeoff_position_w_m = prepared.place.position_w_m,
          .ground_z_m = files.flight ? files.flight->ground_z_m : 0.0,
          .max_start_distance_m = kReach_m,
          .home = home_settings(files),
          .home_yaw_rad = prepared.start.yaw_rad};
}

link::ChannelCommand neutral_of(const FlyOptions& options, const model::Vehicle& vehicle) {
  return options.channel == "movement" ? link::ChannelCommand(ctl::Command<double>{})
                                       : link::ChannelCommand(vrc::CommandMap(vehicle).neutral());
}

void ask_for_real_time() {
  const sched_param priority{.sched_priority = kPriority};
  const bool first = sched_setscheduler(0, SCHED_FIFO, &priority) == 0;
  const bool locked = mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
  if (!first || !locked) {
    print_line(first ? "memory cannot be locked; m100 doctor tells the remedy"
                     : "no real-time rights; m100 doctor tells the remedy");
  }
}

/// In simulated time the flight waits for its log after every so many ticks, whose records the log's ring can hold.
constexpr std::uint32_t kTicksPerWait = 400;
/// Watchdog time-out of the service manager: longer than the backup process's 0.7 s, which handles a hang more gently.
constexpr core::Duration kServiceTimeout = std::chrono::seconds(1);

/// Sends lines to the terminal, the log and the ground station.
class OperatorChannels final : public OperatorLog {
 public:
  OperatorChannels(log::FlightLogWriter* log, TelemetryStream& stream) : log_(log), stream_(stream) {}
  void write(core::TimePoint now, std::string_view line) override {
    TextLine timed;
    timed.add(core::seconds<double>(now.time_since_epoch()), 2).add(" s  ").add(line);
    print_line(timed.text());
    if (log_ != nullptr) {
      log_->append(now, line);
    }
    stream_.publish(line);
  }

 private:
  log::FlightLogWriter* log_;
  TelemetryStream& stream_;
};

/// Whether the second process would give control back if this program died; tells the operator on a change.
bool is_backed_up(BackupProcess& backup, BackupProcess::State& reported, core::TimePoint now,
                  OperatorLog& operator_log) {
  using State = BackupProcess::State;
  const State state = backup.state(now);
  if (std::exchange(reported, state) != state) {
    operator_log.write(now, state == State::kReady ? "the second process runs again"
                            : state == State::kDead
                                ? "the second process is dead: nobody gives control back if this program dies. Land"
                                : "the second process hangs: nobody gives control back if this program dies. Land");
  }
  return state == State::kReady;
}

void heartbeat(BackupProcess& backup, const hal::SerialPort& port, Controller& controller) {
  backup.set_port(port.descriptor(), port.openings());
  if (!backup.heartbeat(controller.link().authority().in_control)) {
    controller.release();
    print_line("this program stalled for too long: control was given back to the transmitter");
  }
}

void report_settings(const FlyOptions& options, const FlightFiles& files, OperatorChannels& channels,
                     core::TimePoint now) {
  if (const std::string lever = describe_lever_arm(*files.flight); !lever.empty()) {
    channels.write(now, lever);
  }
  for (const std::string& check : options.disabled_checks) {
    channels.write(now, TextLine{}.add("--override: check ").add(check).add(" is switched off").text());
  }
}

/// Lets the log catch up in simulated time, in which a flight runs as fast as the machine can.
void wait_for_log(const FlyOptions& options, const std::optional<LogFile>& log, std::uint32_t ticks) {
  if (log && hal::is_simulated(options.port) && ticks % kTicksPerWait == 0) {
    log->wait_until_written();
  }
}

/// The commands of the operator and of the ground station.
OperatorInput received(const PosePort& port, GroundStationCommands& ground_station, const Controller& controller,
                       const FlightSequencer& sequencer, core::TimePoint now) {
  OperatorInput input = read_operator_input();
  if (port.has_ground_station()) {
    const OperatorInput commanded = ground_station.tick(now, controller, sequencer.status(now));
    input.toggle_control = input.toggle_control || commanded.toggle_control;
    input.land = input.land || commanded.land;
  }
  input.goal_led = ground_station.has_goal();
  return input;
}

/// Prints the closing lines, writes the result, and closes the log, which may wait for the medium.
void conclude(const FlyOptions& options, Json result, const Controller& controller, const PosePort& pose,
              const FlightSequencer& sequencer, LineWriter& writer, std::optional<LogFile>& log) {
  writer.finish();
  std::ostringstream words;
  print(words, controller.link().health());
  print(words, controller.pose_link().stats(), pose.signatures());
  if (sequencer.reporter().limit_cycle()) {
    words << describe_limit_cycle(*sequencer.reporter().limit_cycle()).text() << "\n";
  }
  if (!options.log.empty()) {
    words << "  page       m100-lab flight " << printable(options.log) << " --out flight.html  (on the PC)\n";
  }
  write_with_timeout(words.str());
  if (log) {
    result["log_cut"] = log->is_cut();
  }
  write_result(options.json, result);
  if (log) {
    log->finish();
  }
  if (log && log->is_cut()) {
    write_with_timeout("m100: " + log->why_cut() + "\n");
  }
}

/// @returns a function that marks the bytes that have arrived at both ports. It is called just before the time of a
///   tick is taken: the tick reads only these bytes.
auto mark_arrived(hal::SerialPort& port, PosePort& pose_port) {
  return [&] {
    port.mark_arrived();
    pose_port.mark_arrived();
  };
}

}  // namespace

// Deviation: the parts of a flight in the order in which they are made, and the loop that runs them.
bool fly_course(const FlyOptions& options, const link::LinkConfig& link, hal::SerialPort& port) {
  const FlightFiles files = files_of(options);
  const FlightModel model = sound_model(options, files.mode);
  say_design(model.vehicle());
  const link::ChannelCommand neutral = neutral_of(options, model.vehicle());
  const protocol::Cipher* const cipher = link.encrypt_commands ? link.cipher : nullptr;
  BackupProcess backup(neutral, cipher, options.port);  // before the threads and the large objects
  backup.set_port(port.descriptor(), port.openings());
  PosePort pose_port(options.pose, options.port);
  const FlightPreparation prepared(pose_port, options, files, link);
  const app::FlightConfig& config = prepared.config;
  ref::Trajectory<double>& trajectory = *prepared.course;
  TickClock clock(options.port, mark_arrived(port, pose_port));
  std::optional<LogFile> log_file;
  log::FlightLogWriter* const log = begin_log(log_file, options, model, files, prepared, clock.now());
  GroundStationTap pose_line(pose_port.line(), unsigned_sender(options.pose));
  const auto controller =
      std::make_unique<Controller>(model.vehicle(), model.tables(), config, port, pose_line, trajectory, log);
  const link::ReleaseSequence last_words(neutral, cipher);
  LineWriter writer(shows_status(options.live));
  const core::AssertionHandler former = release_on_assertion(last_words, port, controller->link().authority());
  TelemetryStream stream(options.live, pose_port.network(), pose_port.key());
  ask_for_real_time();  // the threads must not inherit it
  OperatorChannels channels(log, stream);
  report_settings(options, files, channels, clock.now());
  GroundStationCommands ground_station(goal_settings(options, files), config.fence, trajectory, pose_line, &stream,
                                       channels);
  FlightSequencer sequencer(request_of(options, files, prepared), config, *controller, trajectory, channels);
  discard_operator_input();
  hal::ServiceWatchdog service;
  service.start(kServiceTimeout);
  core::TimePoint health_logged_at{};
  BackupProcess::State backup_state = BackupProcess::State::kReady;
  StallMonitor stalls(channels);
  for (core::TimePoint now = clock.now();; now = clock.next(), service.feed()) {
    wait_for_log(options, log_file, controller->stats().ticks);
    stalls.tick(now);
    heartbeat(backup, port, *controller);
    pose_port.tick();
    const bool backed_up = is_backed_up(backup, backup_state, now, channels);
    (void)controller->tick(now);  // the log holds the outcome of the command
    const app::TickRecord<double>& record = controller->record();
    stream.publish(record, pose_port.min_time());
    writer.show(record);
    log_health(log, record, health_logged_at);
    OperatorInput input = received(pose_port, ground_station, *controller, sequencer, now);
    input.backed_up = backed_up;
    if (!sequencer.tick(now, input)) {
      break;
    }
  }
  core::set_assertion_handler(former);
  service.stop();
  controller->link().authority().release_pending ? backup.send_release() : backup.dismiss();
  Json result = flight_result(options, files, sequencer, *controller, clock.stalls(), config.limits);
  result.update(pose_result(*controller, pose_port.signatures(), sequencer.clock_steps(), pose_line.stats()));
  conclude(options, std::move(result), *controller, pose_port, sequencer, writer, log_file);
  return sequencer.given_back() && is_excited(files, *controller) && !sequencer.reporter().limit_cycle();
}

}  // namespace m100::companion
