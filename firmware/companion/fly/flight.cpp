// SPDX-License-Identifier: BSD-3-Clause
// m100 fly: flies a course with the flight controller, from the first pose to the handover.
#include <sched.h>
#include <sys/mman.h>

#include <array>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/files/log_file.h"
#include "firmware/companion/fly/flight_model.h"
#include "firmware/companion/fly/flight_result.h"
#include "firmware/companion/fly/fly.h"
#include "firmware/companion/fly/keeper.h"
#include "firmware/companion/fly/link_report.h"
#include "firmware/companion/fly/margin_certificate.h"
#include "firmware/companion/fly/model_findings.h"
#include "firmware/companion/fly/pilotage.h"
#include "firmware/companion/fly/preparation.h"
#include "firmware/companion/fly/screen.h"
#include "firmware/companion/fly/words.h"
#include "firmware/companion/room/room_orders.h"
#include "firmware/companion/subcommands.h"
#include "firmware/link/farewell.h"
#include "firmware/vrc/command_map.h"
#include "hal/linux/service_watchdog.h"

namespace m100::companion {
namespace {

/// Which numbers fly, and what is proved of them.
void say_design(const FlyOptions& options, const model::Vehicle& vehicle, Mode mode) {
  if (!vehicle.design.exists() && mode != Mode::kCalmRoom) {
    say("the vehicle file has no [design]: the identified axes and [mpc] fly; m100-lab gains --tune makes one");
  }
  if (const std::optional<MarginCertificate> certificate = certificate_beside(options.vehicle, options.gains)) {
    say("certificate " + certificate->text());
  }
}

using Controller = app::FlightController<double>;
constexpr int kPriority = 50;  ///< of SCHED_FIFO, if it is granted
/// Largest distance from the beginning of the course at which control is taken. A pilot's hover wanders by a metre; a
/// longer way there would be a course that the operator did not order.
constexpr double kReach_m = 1.5;

// An assertion handler can only use globals.
hal::SerialPort* farewell_port = nullptr;
const link::Farewell* farewell = nullptr;
const link::AuthorityView* farewell_authority = nullptr;

void say_farewell(const char* file, int line) {
  // The neutral command is a control command: it must not be sent when the pilot has control (promise R4).
  (void)farewell_port->write(farewell_authority->in_control ? farewell->bytes() : farewell->giving_back());
  std::cerr << "m100: broken invariant at " << file << ":" << line << "; control was released\n";
  std::_Exit(kAnswerIsNo);
}

/// Makes a broken invariant send the farewell from now on. @returns the former handler.
core::AssertionHandler say_when_broken(const link::Farewell& last_words, hal::SerialPort& port,
                                       const link::AuthorityView& authority) {
  farewell = &last_words;
  farewell_port = &port;
  farewell_authority = &authority;
  return core::set_assertion_handler(&say_farewell);
}

/// Whether the excitation was flown to its end, if there is one.
bool is_excited(const Orders& orders, const Controller& controller) {
  return !orders.excitation || controller.excitation().state() == ctl::Excitation<double>::State::kOver;
}

void expect_files(const FlyOptions& options) {
  if (options.pose.port.empty() || options.vehicle.empty() || options.gains.empty() || options.flight.empty()) {
    throw UsageError("fly: needs --pose-port, --vehicle, --gains and --flight (or --dry-run)");
  }
}

/// @param place where the aircraft was when the program began
Wishes wishes_of(const FlyOptions& options, const Orders& orders, const ref::Waypoint<double>& place,
                 const ref::Waypoint<double>& start) {
  return {.take_control = options.take_control,
          .hold_s = options.hold_s,
          .once = options.once,
          .take_off = options.take_off,
          .land = options.land,
          .begins_w_m = start.position_w_m,
          .stands_w_m = place.position_w_m,
          .reach_m = kReach_m,
          .home = home_settings(orders),
          .home_yaw_rad = start.yaw_rad};
}

link::ChannelCommand neutral_of(const FlyOptions& options, const model::Vehicle& vehicle) {
  return options.channel == "movement" ? link::ChannelCommand(ctl::Command<double>{})
                                       : link::ChannelCommand(vrc::CommandMap(vehicle).neutral());
}

/// Sets the buffer of the standard output now: the library would allocate it in flight, with the first line (R1).
void give_output_its_buffer() {
  static std::array<char, BUFSIZ> buffer;
  (void)std::setvbuf(stdout, buffer.data(), _IOFBF, buffer.size());
}

void ask_for_real_time() {
  const sched_param priority{.sched_priority = kPriority};
  const bool first = sched_setscheduler(0, SCHED_FIFO, &priority) == 0;
  const bool locked = mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
  if (!first || !locked) {
    std::cout << (first ? "memory cannot be locked" : "no real-time rights") << "; m100 doctor tells the remedy\n";
  }
}

/// Prepares the thread that flies for its first tick.
/// @returns the speaker to the room; null: there is none.
Speaker* prepare_the_thread(PosePort& pose_port, Live& live) {
  give_output_its_buffer();
  Speaker* const speaker = pose_port.start_speaker();  // before the steps whose effects the threads must not inherit
  live.start();
  ask_for_real_time();
  return speaker;
}

/// In simulated time the flight waits for its log after so many ticks: the log's ring holds more than they produce.
constexpr std::uint32_t kTicksPerWait = 400;
constexpr core::Duration kHealthPeriod = std::chrono::seconds(1);  ///< of the link's health in the log
/// Watchdog time-out of the service manager: longer than the keeper's 0.7 s, which handles a hang more gently.
constexpr core::Duration kServicePatience = std::chrono::seconds(1);

/// Sends lines to the terminal, the log and the room.
class Ears final : public Listener {
 public:
  /// @param speaker to the room; may be null.
  Ears(log::FlightLogWriter* log, Speaker* speaker) : log_(log), speaker_(speaker) {}
  void hear(core::TimePoint now, std::string_view line) override {
    TextLine timed;
    timed.add(core::seconds<double>(now.time_since_epoch()), 2).add(" s  ").add(line);
    say(timed.text());
    if (log_ != nullptr) {
      log_->append(now, line);
    }
    if (speaker_ != nullptr) {
      speaker_->tell(line);
    }
  }

 private:
  log::FlightLogWriter* log_;
  Speaker* speaker_;
};

/// Logs the health of the link once a second.
class HealthLog {
 public:
  explicit HealthLog(log::FlightLogWriter* log) : log_(log) {}
  void tick(core::TimePoint now, const link::LinkHealth& health) {
    if (log_ != nullptr && now - logged_at_ >= kHealthPeriod) {
      log_->append(now, health_line(health, text_));
      logged_at_ = now;
    }
  }

 private:
  log::FlightLogWriter* log_;
  core::TimePoint logged_at_{};
  HealthText text_{};
};

/// Watches whether the second process would give control back if this program died; tells the operator on a change.
class GuardWatch {
 public:
  GuardWatch(Keeper& keeper, Listener& listener) : keeper_(keeper), listener_(listener) {}
  /// @returns true: it would.
  bool tick(core::TimePoint now) {
    const Keeper::Guard guard = keeper_.guard(now);
    if (guard != told_) {
      told_ = guard;
      listener_.hear(now, guard == Keeper::Guard::kStands ? "the second process runs again"
                          : guard == Keeper::Guard::kDead
                              ? "the second process is dead: nobody gives control back if this program dies. Land"
                              : "the second process hangs: nobody gives control back if this program dies. Land");
    }
    return guard == Keeper::Guard::kStands;
  }

 private:
  Keeper& keeper_;
  Listener& listener_;
  Keeper::Guard told_ = Keeper::Guard::kStands;
};

void say_what_is_off(const FlyOptions& options, Ears& ears, core::TimePoint now) {
  for (const std::string& check : options.checks_off) {
    ears.hear(now, TextLine{}.add("--override: check ").add(check).add(" is switched off").text());
  }
}

/// @returns null: no log was requested.
log::FlightLogWriter* begin_log(std::optional<LogFile>& file, const FlyOptions& options, const FlightModel& model,
                                const Orders& orders, const ref::Waypoint<double>& start,
                                const app::FlightConfig& config, core::TimePoint now) {
  if (options.log.empty()) {
    return nullptr;
  }
  file.emplace(options.log);
  write_notes(file->log(), options, model, orders, start, config, now);
  file->start();
  return &file->log();
}

/// Lets the log catch up in simulated time, in which a flight runs as fast as the machine can.
void let_the_log_follow(const FlyOptions& options, const std::optional<LogFile>& log, std::uint32_t ticks) {
  if (log && hal::is_simulated(options.port) && ticks % kTicksPerWait == 0) {
    log->wait_until_written();
  }
}

/// The commands of the operator and of the room.
OperatorInput heard(const PosePort& port, RoomOrders& room, const Controller& controller, const Pilotage& pilotage,
                    core::TimePoint now) {
  const Said said = heard_from_operator();
  const Said ordered = port.signatures() != nullptr ? room.tick(now, controller, situation_of(pilotage, now)) : Said{};
  return {.word = said.word || ordered.word, .land = said.land || ordered.land, .stops = stops(), .led = room.leads()};
}

/// Prints the closing lines and writes the result.
void conclude(const FlyOptions& options, nlohmann::json result, const Controller& controller, const PosePort& pose,
              Live& live) {
  live.finish();  // its status line must not mix with the closing lines
  std::ostringstream words;
  print(words, controller.link().health());
  print(words, controller.pose_link().stats(), pose.signatures());
  std::cout << std::flush;
  write_at_last(words.str());
  result["pose_link"] = companion::to_json(controller.pose_link().stats(), pose.signatures());
  write_result(options.json, result);
}

}  // namespace

bool fly_course(const FlyOptions& options, const link::LinkConfig& link, hal::SerialPort& port) {
  expect_files(options);
  const Orders orders(options);
  const FlightModel model = sound_model(options, orders.mode);
  say_design(options, model.vehicle(), orders.mode);
  const link::ChannelCommand neutral = neutral_of(options, model.vehicle());
  const protocol::Cipher* const cipher = link.encrypt_commands ? link.cipher : nullptr;
  Keeper keeper(neutral, cipher, options.port);  // before the threads and the large objects
  keeper.hold(port.descriptor(), port.openings());
  PosePort pose_port(options.pose, options.port);
  const ref::Waypoint<double> place = first_pose(pose_port);
  const ref::Waypoint<double> start = options.take_off ? above(place) : place;
  const auto trajectory = std::make_unique<ref::Trajectory<double>>();
  lay_and_check(orders, start, *trajectory);
  const app::FlightConfig config = flight_config(options, orders, start, link);
  TickClock clock(options.port);
  std::optional<LogFile> log_file;
  log::FlightLogWriter* const log = begin_log(log_file, options, model, orders, start, config, clock.now());
  Live live(options.live);
  OverheardLine pose_line(pose_port.line());
  const auto controller =
      std::make_unique<Controller>(model.vehicle(), model.tables(), config, port, pose_line, *trajectory, log);
  const link::Farewell last_words(neutral, cipher);
  const core::AssertionHandler former = say_when_broken(last_words, port, controller->link().authority());
  Speaker* const speaker = prepare_the_thread(pose_port, live);
  Ears ears(log, speaker);
  say_what_is_off(options, ears, clock.now());
  RoomOrders room(goal_limits(options, orders), model.vehicle(), config, *trajectory, pose_line, speaker, ears);
  Pilotage pilotage(wishes_of(options, orders, place, start), config, *controller, *trajectory, ears);
  forget_words();
  hal::ServiceWatchdog service;
  service.start(kServicePatience);
  HealthLog health(log);
  GuardWatch guard(keeper, ears);
  for (core::TimePoint now = clock.now();; now = clock.next(), service.feed()) {
    let_the_log_follow(options, log_file, controller->stats().ticks);
    keeper.hold(port.descriptor(), port.openings());
    if (!keeper.beat(controller->link().authority().in_control)) {
      controller->release();
      say("this program stalled for too long: control was given back to the transmitter");
    }
    pose_port.tick();
    const bool guarded = guard.tick(now);
    (void)controller->tick(now);  // the log holds the outcome of the command
    pose_port.tell(*controller, now);
    live.tell(*controller, *trajectory, now);
    health.tick(now, controller->link().health());
    OperatorInput input = heard(pose_port, room, *controller, pilotage, now);
    input.guarded = guarded;
    if (!pilotage.tick(now, input)) {
      break;
    }
  }
  core::set_assertion_handler(former);
  service.stop();
  controller->link().authority().owed ? keeper.speak() : keeper.dismiss();
  nlohmann::json result = flight_result(options, orders, pilotage, *controller, clock.stalls(), config.limits);
  result["room"] = room_result(pose_line.stats(), room.parameters_not_set());
  conclude(options, std::move(result), *controller, pose_port, live);
  return pilotage.given_back() && is_excited(orders, *controller);
}

}  // namespace m100::companion
