// SPDX-License-Identifier: BSD-3-Clause
// m100 fly: the options of a flight, and what the dry run and the flight share.
#include "firmware/app/linux/fly.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>

#include "firmware/app/linux/key_file.h"
#include "firmware/app/linux/subcommands.h"
#include "firmware/app/linux/text_file.h"
#include "protocol/aes256.h"

namespace m100::app {
namespace {

volatile std::sig_atomic_t stop_signal = 0;
void on_signal(int) { stop_signal = 1; }

LinkConfig link_config(const FlyOptions& options) {
  LinkConfig config;
  config.baud = options.baud;
  config.app_id = options.app_id;
  config.channel = {.channel = options.channel == "movement" ? Channel::kMovement : Channel::kVirtualRc,
                    .rate_hz = options.rate_hz,
                    .paper_100_hz = options.paper_100_hz};
  if (!command_period(config.channel)) {
    throw UsageError(
        "--rate: virtual_rc takes 5 to 25 Hz, movement 1 to 50 Hz; the paper's 100 Hz is asked for with "
        "--paper-100hz");
  }
  return config;
}

void run(const FlyOptions& options) {
  if (std::isnan(options.hold_s) || std::isnan(options.patience_s)) {  // passes every comparison of a range
    throw UsageError(std::isnan(options.hold_s) ? "--hold: is not a number" : "--patience: is not a number");
  }
  LinkConfig config = link_config(options);
  std::optional<protocol::Aes256> cipher;
  if (!options.key_file.empty()) {
    cipher.emplace(read_key(options.key_file));
    config.cipher = &*cipher;
    config.encrypt_commands = true;
  }
  expect_writable(options.json);
  watch_signals();
  hal::SerialPort port(options.port, options.baud);
  open_or_explain(port);
  const bool done = options.dry_run ? dry_run(options, config, port) : fly_course(options, config, port);
  if (!done) {
    throw CLI::RuntimeError(kAnswerIsNo);
  }
}

}  // namespace

bool stop_asked() { return stop_signal != 0; }

void watch_signals() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  std::signal(SIGHUP, on_signal);  // the terminal is gone, the aircraft is not
  // A reader of our output that left, or a log that may not grow, must not end a flight.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

bool key_pressed() {
  pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  char line[64];
  return poll(&input, 1, 0) > 0 && read(STDIN_FILENO, line, sizeof line) > 0;
}

void say(const std::string& line) {
  pollfd output{.fd = STDOUT_FILENO, .events = POLLOUT, .revents = 0};
  if (poll(&output, 1, 0) > 0 && (output.revents & POLLOUT) != 0) {
    std::cout << line << std::endl;
  }
}

void open_or_explain(hal::SerialPort& port) {
  switch (port.open()) {
    case core::Status::kOk:
      return;
    case core::Status::kRefused:
      throw UsageError(port.path() + ": no right to open it, or another program holds it (m100 doctor tells more)");
    case core::Status::kInvalidArgument:
      throw UsageError(port.path() + ": this baud rate is not supported");
    default:
      throw UsageError(port.path() +
                       (std::filesystem::exists(port.path()) ? ": is not a serial port" : ": no such serial port"));
  }
}

std::string describe(const AuthorityView& authority) {
  const bool answered = authority.reason == safety::Reason::kAnswer;
  const std::string_view remedy = answered ? authority.answer.remedy : safety::remedy(authority.reason);
  std::string text(safety::name(authority.stage));
  text += " (" + std::string(safety::name(authority.reason)) + ")";
  text += answered ? ": " + std::string(authority.answer.name) : "";
  text += remedy.empty() ? "" : "; " + std::string(remedy);
  return text;
}

core::TimePoint TickClock::next() {
  const core::TimePoint now = clock_.now();
  const bool late = now - deadline_ > core::kTickPeriod;
  deadline_ = (late ? now : deadline_) + core::kTickPeriod;
  clock_.sleep_until(deadline_);
  const core::TimePoint woken = clock_.now();
  if (last_ != core::TimePoint{}) {
    stalls_ += woken - last_ > 2 * core::kTickPeriod ? 1U : 0U;
    longest_ = std::max(longest_, woken - last_);
  }
  last_ = woken;
  return woken;
}

void add_fly(CLI::App& m100) {
  CLI::App* app = m100.add_subcommand("fly", "take control of the autopilot at a serial port, and give it back");
  auto options = std::make_shared<FlyOptions>();
  app->add_option("--port", options->port, "serial port of the autopilot")->required();
  app->add_option("--baud", options->baud, "as set in DJI's assistant")
      ->check(CLI::IsMember({115200, 230400, 460800, 921600}));
  app->add_option("--app-id", options->app_id, "from DJI's developer site");
  app->add_option("--key-file", options->key_file, "file with the app's key, 64 hexadecimal digits; encrypts commands");
  app->add_option("--channel", options->channel, "how commands are sent")
      ->check(CLI::IsMember({"virtual_rc", "movement"}));
  app->add_option("--rate", options->rate_hz, "commands per second, inside the channel's window");
  app->add_flag("--paper-100hz", options->paper_100_hz, "the paper's command rate, beyond what DJI allows");
  app->add_flag("--dry-run", options->dry_run, "neutral commands only: start-up, control, hold, release; then exit");
  app->add_flag("--take-control", options->take_control,
                "ask for control once as soon as all is ready, and give it back after --hold");
  app->add_option("--hold", options->hold_s, "seconds in control, in a dry run and with --take-control")
      ->check(CLI::Range(0.0, 3600.0));
  app->add_option("--patience", options->patience_s, "seconds to wait for start-up in a dry run")
      ->check(CLI::Range(1.0, 3600.0));
  app->add_option("--pose-port", options->pose_port, "serial port of the pose (protocol/pose_message.h)");
  app->add_option("--pose-baud", options->pose_baud, "its baud rate")
      ->check(CLI::IsMember({115200, 230400, 460800, 921600}));
  app->add_option("--vehicle", options->vehicle, "vehicle file (TOML)");
  app->add_option("--gains", options->gains, "gain table file, made from that vehicle file by m100-lab gains");
  app->add_option("--course", options->course, "course file; default: hover where the aircraft is");
  app->add_option("--log", options->log, "flight log to write (ULog); must not exist");
  app->add_option("--json", options->json, "result as JSON");
  app->callback([options] { run(*options); });
}

}  // namespace m100::app
