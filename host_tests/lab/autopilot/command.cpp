// SPDX-License-Identifier: BSD-3-Clause
// m100-lab autopilot: emulates an N1 autopilot with its vehicle, on a pseudo-terminal in real time, on simulated ports
// that also carry the simulated time, or in lockstep with a flight image in QEMU.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <iostream>
#include <optional>
#include <string>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/text/key_file.h"
#include "hal/linux/simulated_port.h"
#include "host_tests/lab/autopilot/event_file.h"
#include "host_tests/lab/autopilot/line.h"
#include "host_tests/lab/autopilot/run.h"
#include "host_tests/lab/body_options.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/subcommands.h"
#include "host_tests/lab/whole_file.h"
#include "host_tests/sim/autopilot/real_autopilot_file.h"
#include "host_tests/sim/body/body_plant.h"
#include "host_tests/sim/ports/emulated_board.h"
#include "host_tests/sim/ports/world.h"
#include "protocol/aes256.h"

namespace m100::lab {
namespace autopilot {
namespace {

volatile std::sig_atomic_t stop_signal = 0;
void request_stop(int) { stop_signal = 1; }

std::string read_text(const std::string& path) { return whole_file(path, companion::kMaxTextBytes); }

std::vector<sim::N1ScriptLine> read_script(const std::string& path) {
  try {
    return sim::read_n1_script(read_text(path));
  } catch (const sim::N1ScriptError& wrong) {
    throw InputError(path, wrong.line(), "", wrong.what());
  }
}

sim::N1Behaviour behaviour_of(const Options& options) {
  sim::N1Behaviour behaviour =
      options.real.empty() ? sim::N1Behaviour{} : sim::parse_real_autopilot(read_text(options.real), options.real);
  behaviour.virtual_rc.data_under_switch_id |= options.lenient_virtual_rc;
  return behaviour;
}

void expect_one_line(const Options& options) {
  const int lines = static_cast<int>(!options.pty.empty()) + static_cast<int>(!options.simulated.empty()) +
                    static_cast<int>(!options.board.empty());
  if (lines != 1) {
    throw InputError("--pty", 0, "", "one of --pty, --sim and --board is needed");
  }
  if (!options.pty.empty() && options.pose_pty == options.pty) {
    throw InputError("--pose-pty", 0, "", "must not be the link of --pty");
  }
  if (!options.pose_pty.empty() && hal::is_simulated(options.pty) != hal::is_simulated(options.pose_pty)) {
    throw InputError("--pose-pty", 0, "",
                     "a simulated port and a real one cannot be combined: they do not share the same time");
  }
  options.body.check();
  if (!options.board.empty() && !options.body.is_identified()) {
    throw InputError("--body", 0, "", "the image in QEMU flies the identified response only");
  }
}

void check_files(const Options& options) {
  companion::FileUse use;
  use.reads("--plant", options.plant)
      .reads("--plant-from", options.plant_from)
      .reads("--key-file", options.key_file)
      .reads("--real", options.real)
      .reads("--script", options.script == kLiveScript ? "" : options.script)
      .reads("--board", options.board)
      .writes("--events", options.events);
  for (const auto& [option, link] : {std::pair("--pty", options.pty), std::pair("--pose-pty", options.pose_pty)}) {
    use.names(option, hal::is_simulated(link) ? "" : link);
  }
  for (const char* const end : {"", ".pose", ".n1", ".n1.pose"}) {
    use.names("--sim", options.simulated.empty() ? "" : options.simulated + end);
  }
  use.check();
}

/// Runs the flight image in QEMU, for 30 s without --duration: its UART1 is the autopilot's line, its UART2 the pose,
/// and the simulation drives its clock. The operator requests control after 6 s and releases it 3 s before the end.
/// @throws companion::AnswerIsNo  the image ended with another exit status than 0
void run_with_board(const Options& options, const sim::Plant& plant, const sim::N1Config& config) {
  sim::World world(plant, {.seed = options.seed, .autopilot = config});
  std::optional<EventFile> events;
  if (!options.events.empty()) {
    events.emplace(options.events, EventFile::WriteMode::kAtOnce);
    world.autopilot().on_event([&](const sim::N1Event& event) { events->write(event); });
  }
  world.autopilot().happen(sim::N1EventKind::kLoss, options.loss);
  sim::EmulatedBoard board(options.board, "lockstep " + options.course);
  const int ticks = static_cast<int>((options.duration_s > 0.0 ? options.duration_s : 30.0) * 100.0);
  const core::Vector<double, 3> start = world.vehicle().state().position_w_m;
  double farthest_m = 0.0;
  for (int tick = 0; tick < ticks && !stop_requested(); ++tick) {
    world.pose_source().set_faults({.silent = !world.autopilot().pose_on()});
    world.advance(core::kTickPeriod);
    const hal::LockstepOrder order =
        tick == 600 ? hal::LockstepOrder::kEngage
                    : (tick == ticks - 300 ? hal::LockstepOrder::kRelease : hal::LockstepOrder::kNone);
    board.step(world.now(), order, world.autopilot_uart(), world.pose_uart());
    farthest_m = std::max(farthest_m, (world.vehicle().state().position_w_m - start).norm());
    if (events) {
      events->write_truth(world.now(), world.vehicle().state());
    }
  }
  const int exit_status = board.end();
  std::cout << options.course << " flown by " << options.board << ": " << world.autopilot().record().virtual_rc_taken
            << " stick commands taken, at most " << farthest_m << " m from the start, exit status " << exit_status
            << std::endl;
  if (events) {
    events->summarise(world.now(), world.autopilot(), core::Duration{0});
  }
  if (exit_status != 0) {
    throw companion::AnswerIsNo();
  }
}

void run(const Options& options) {
  expect_one_line(options);
  check_files(options);
  const sim::Plant plant = sim::plant_of_options(options.body, options.plant, options.plant_from);
  std::optional<protocol::Aes256> cipher;
  if (!options.key_file.empty()) {
    cipher.emplace(companion::read_key(options.key_file));
  }
  sim::N1Config config{.baud = options.baud,
                       .seed = options.seed,
                       .mode = static_cast<sim::N1Mode>(options.mode.front()),
                       .cipher = cipher ? &*cipher : nullptr,
                       .app_id = options.app_id,
                       .noise = sim::noise_of(plant.sensors),
                       .clock_drift_ppm = plant.link.clock_drift_ppm,
                       .behaviour = behaviour_of(options),
                       .pilot_holds_position = options.board.empty()};
  if (!options.script.empty() && options.script != kLiveScript) {
    config.script = read_script(options.script);
  }
  std::signal(SIGINT, request_stop);
  std::signal(SIGTERM, request_stop);
  if (options.board.empty()) {
    run_on_line(options, plant, config);
  } else {
    run_with_board(options, plant, config);
  }
}

void add_options(const companion::Subcommand& app, Options& options) {
  app.add_option(
      "--pty", options.pty,
      "symbolic link to create; clients open it like a serial port. sim:SOCKET: join another program's simulated time "
      "instead");
  app.add_option("--pose-pty", options.pose_pty, "a second link, with the pose of the vehicle");
  app.add_option("--sim", options.simulated,
                 "socket to create: clients open sim:SOCKET, and sim:SOCKET.pose for the pose, and fly faster than "
                 "real time; simulated time starts when the first client connects")
      .excludes("--pty");
  app.add_option(
         "--board", options.board,
         "flight image to run in QEMU instead (m100_mps2.elf): its UART1 is the line, its UART2 the pose, in lockstep")
      .excludes("--pty");
  app.add_option("--course", options.course, "course that the board flies")
      .one_of({"hover", "step", "trajectory"})
      .needs("--board");
  add_body_options(app, options.body);
  app.add_option("--plant", options.plant, "plant file (TOML); default: the measured aircraft");
  app.add_option(
      "--plant-from", options.plant_from,
      "vehicle file that gives the world its axes, drag and thrust instead of the measured ones; --plant lists the "
      "differences from it");
  app.add_option("--seed", options.seed, "seed of all noise").whole_number();
  app.add_option("--rc-mode", options.mode, "mode switch of the remote controller at the start")
      .one_of({"F", "A", "P"});
  app.add_option(
      "--script", options.script,
      "events with their times: lines of SECONDS WHAT [VALUE], e.g. '12.5 mode A', '20 take mobile', '25 restart'; "
      "'-': each line of standard input happens when it arrives");
  app.add_option("--real", options.real,
                 "what was seen on a real autopilot (TOML, guide/FIRST_CONTACT.md), in place of the assumptions");
  app.add_option(
      "--events", options.events,
      "file for JSON lines: what the autopilot received and did, and where the aircraft is; the last line is a "
      "summary");
  app.add_option("--baud", options.baud,
                 "line rate in both directions; bytes are garbled if the client's rate differs; 0: no rate limit")
      .one_of({0, 115200, 230400, 460800, 921600});
  app.add_option("--app-id", options.app_id, "the only app id to activate; default: any");
  app.add_option("--key-file", options.key_file,
                 "file with the app's AES key (64 hexadecimal digits, readable by its owner only)");
  app.add_option("--loss", options.loss, "share of the frames that is lost in each direction").in_range(0.0, 1.0);
  app.add_option("--duration", options.duration_s, "seconds; default: until interrupted, with --board 30")
      .in_range(0.001, 1e6);
  app.add_flag(
         "--on-ground", options.on_ground,
         "the aircraft stands on the ground, motors stopped, until a take-off; default: held at 1.5 m by its pilot")
      .excludes("--board");
  app.add_flag("--lenient-virtual-rc", options.lenient_virtual_rc,
               "accept 64 bytes under the on/off id as stick data, as clients of SDK 3.3 to 4.1 send them");
}

}  // namespace

bool stop_requested() { return stop_signal != 0; }

}  // namespace autopilot

void add_autopilot(companion::CommandLine& lab) {
  const auto [app, options] = lab.add_subcommand<autopilot::Options>(
      "autopilot", "emulate an N1 autopilot with a vehicle on a pseudo-terminal", autopilot::run);
  autopilot::add_options(app, *options);
}

}  // namespace m100::lab
