// SPDX-License-Identifier: BSD-3-Clause
// m100 fly: the options of a flight, and functions shared by the dry run, the handshake and the flight.
#include "firmware/companion/fly/fly.h"

#include <termios.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <csignal>
#include <filesystem>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/course/course.h"
#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/text/key_file.h"
#include "firmware/companion/fly/flight.h"
#include "firmware/companion/mode_option.h"
#include "firmware/companion/operator/line_writer.h"
#include "firmware/companion/operator/operator_messages.h"
#include "firmware/companion/operator/terminal.h"
#include "firmware/companion/preflight/dry_run.h"
#include "firmware/companion/preflight/model_findings.h"
#include "firmware/companion/preflight/serial_ports.h"
#include "firmware/companion/subcommands.h"
#include "hal/linux/system_calls.h"

namespace m100::companion {
namespace {

std::atomic<std::uint32_t> stop_signals{0};
std::atomic<bool> word_signal{false};
static_assert(std::atomic<std::uint32_t>::is_always_lock_free, "handlers of signals may touch no other");
void on_signal(int) { ++stop_signals; }
void on_toggle_signal(int) { word_signal = true; }

link::LinkConfig link_config(const FlyOptions& options) {
  link::LinkConfig config;
  config.baud = options.baud;
  config.app_id = options.app_id;
  config.channel = {.channel = options.channel == "movement" ? link::Channel::kMovement : link::Channel::kVirtualRc,
                    .rate_hz = options.rate_hz,
                    .paper_100_hz = options.paper_100_hz};
  if (!link::command_period(config.channel)) {
    throw UsageError(
        "--rate: virtual_rc takes 5 to 25 Hz, movement 1 to 50 Hz; the paper's 100 Hz needs --paper-100hz");
  }
  return config;
}

void run(const FlyOptions& options) {
  check(options.pose, options.port);
  (void)receiver_of(options.live.to);  // refuses a malformed address before anything begins
  if (!options.excite.empty() && options.channel != "virtual_rc") {
    throw UsageError("--excite: moves sticks, and needs --channel virtual_rc");
  }
  const PreparedLink prepared(options);
  watch_signals();
  hal::SerialPort port(options.port, options.baud);
  open_or_explain(port);
  if (!options.dry_run) {
    make_terminals_nonblocking();
  }
  const bool done =
      options.dry_run ? dry_run(options, prepared.config, port) : fly_course(options, prepared.config, port);
  if (!done) {
    throw AnswerIsNo();
  }
}

}  // namespace

void check_files(const FlyOptions& options) {
  FileUse use = files_of(options.pose, options.port);
  use.reads("--key-file", options.key_file)
      .reads("--vehicle", options.vehicle)
      .reads("--gains", options.gains)
      .reads("--flight", options.flight)
      .reads("--course", options.course)
      .reads("--excite", options.excite)
      .writes("--json", options.json)
      .creates("--log", options.log)
      .check();
}

PreparedLink::PreparedLink(const FlyOptions& options) : config(link_config(options)) {
  check_files(options);
  if (!options.key_file.empty()) {
    cipher.emplace(read_key(options.key_file));
    config.cipher = &*cipher;
    config.encrypt_commands = true;
  }
}

std::uint32_t stops() { return stop_signals; }

void watch_signals() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  std::signal(SIGHUP, on_signal);  // without its terminal the program must still end the flight in order
  std::signal(SIGQUIT, on_signal);
  std::signal(SIGUSR1, on_toggle_signal);
  // The shell's job control must not stop a program that flies: Ctrl-Z ends the flight in order, and use of the
  // terminal from the background does not stop it.
  std::signal(SIGTSTP, on_signal);
  std::signal(SIGTTIN, SIG_IGN);
  std::signal(SIGTTOU, SIG_IGN);
  // A closed reader of our output, or a log at its size limit, must not end a flight.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

OperatorInput read_operator_input() {
  std::array<char, 64> line{};
  int waiting = 0;  // 0 at the end of a file, too. On a terminal poll() would wait for a kernel worker
  const bool some = hal::count_waiting(STDIN_FILENO, &waiting) == 0 && waiting > 0;
  const ssize_t count = some ? read(STDIN_FILENO, line.data(), line.size()) : 0;
  const std::string_view typed(line.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  const bool land = typed.substr(0, typed.find_first_of("\r\n")) == "land";
  const bool signalled = word_signal.exchange(false);
  return {.toggle_control = signalled || (!typed.empty() && !land), .land = land, .stops = stops()};
}

void discard_operator_input() {
  word_signal = false;
  (void)tcflush(STDIN_FILENO, TCIFLUSH);
}

void print_line(std::string_view line) {
  if (LineWriter* const writer = LineWriter::current()) {
    writer->push(line);
    return;
  }
  write_with_timeout(TextLine{}.add(line).add("\n").text());
}

void open_or_explain(hal::SerialPort& port) {
  switch (port.open()) {
    case core::Status::kOk:
      return;
    case core::Status::kRefused:
      throw UsageError(port.path() + ": no permission to open it, or another program holds it" +
                       holders_note(port.path()) + " (m100 doctor tells more)");
    case core::Status::kInvalidArgument:
      throw UsageError(port.path() + ": this baud rate is not supported");
    default:
      throw UsageError(port.path() + (std::filesystem::exists(port.path())
                                          ? ": is not a serial port"
                                          : ": no such serial port: " + missing_port_remedy(port.path())));
  }
}

core::TimePoint TickClock::next() {
  const core::TimePoint ended = clock_.now();
  const bool late = ended - deadline_ > core::kTickPeriod;
  deadline_ = (late ? ended : deadline_) + core::kTickPeriod;
  clock_.sleep_until(deadline_);
  const core::TimePoint woken = now();
  if (last_ != core::TimePoint{}) {
    stalls_ += woken - last_ > 2 * core::kTickPeriod ? 1U : 0U;
    longest_ = std::max(longest_, woken - last_);
  }
  last_ = woken;
  return woken;
}

void add_link_options(const Subcommand& app, FlyOptions& options) {
  app.add_option("--port", options.port, "serial port of the autopilot").required();
  app.add_option("--baud", options.baud, "baud rate, as set in DJI's assistant")
      .one_of({115200, 230400, 460800, 921600});
  app.add_option("--app-id", options.app_id, "app id from DJI's developer site");
  app.add_option("--key-file", options.key_file,
                 "file with the app's key (64 hexadecimal digits, readable by its owner only); encrypts the commands");
  app.add_option("--channel", options.channel, "how commands are sent").one_of({"virtual_rc", "movement"});
  app.add_option("--rate", options.rate_hz,
                 "commands per second, inside the channel's window; 0: the channel's default");
  app.add_flag("--paper-100hz", options.paper_100_hz,
               "the paper's command rate of 100 Hz, which is more than DJI allows");
  app.add_option("--json", options.json, "result as JSON");
}

void add_fly(CommandLine& m100) {
  const auto [app, options] = m100.add_subcommand<FlyOptions>(
      "fly", "fly a course by the pose at a second port, inside the flight file's fence", run);
  add_link_options(app, *options);
  app.add_flag("--dry-run", options->dry_run,
               "send nothing at all: read and check the files, listen, estimate and log for --hold seconds; then exit");
  app.add_flag("--take-control", options->take_control,
               "ask for control once as soon as all is ready, and give it back after --hold");
  app.add_flag("--take-off", options->take_off,
               "an aircraft on the ground takes off first, by the autopilot's own task, when the operator orders the "
               "flight; the course begins 1.2 m above the ground, and --hold counts from there");
  app.add_flag("--land", options->land,
               "land at the end of --hold, by the autopilot's own task, and give control back on the ground")
      .needs("--take-control");
  app.add_flag("--once", options->once, "for scripts: end (exit code 1) where the program would wait for the operator");
  app.add_option("--hold", options->hold_s, "seconds in control, with --take-control; length of a dry run")
      .in_range(0.0, 3600.0);
  add_pose_options(app, options->pose);
  app.add_option("--vehicle", options->vehicle, "vehicle file (TOML)");
  app.add_option("--gains", options->gains, "gain table file, made from that vehicle file by m100-lab gains");
  app.add_option("--flight", options->flight, "flight file (TOML): the fence and the other limits of the flight");
  add_mode_option(app, options->mode, "tuning; default: as in the flight file");
  app.add_option("--law", options->law, "horizontal control law; lqr: the clipped baseline, for comparison")
      .one_of({"mpc", "lqr"});
  app.add_option("--override", options->disabled_checks,
                 "switch off one check of the pose against the autopilot's telemetry, or fly in spite of what m100 "
                 "check finds wrong: give the name of either; may be repeated")
      .one_of(names_for_override());
  app.add_option("--course", options->course, "course file; default: hover where the aircraft is");
  app.add_option("--excite", options->excite,
                 "stick movements of m100-lab excite --out, flown stick by stick around where the aircraft is; with "
                 "--take-control, --hold counts from their end")
      .excludes("--course");
  app.footer(course_help());
  add_live_options(app, options->live);
  app.add_option("--log", options->log, "flight log to write (ULog); must not exist");
}

}  // namespace m100::companion
