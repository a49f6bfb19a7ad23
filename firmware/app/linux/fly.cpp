// SPDX-License-Identifier: BSD-3-Clause
// m100 fly: from start-up to release against an autopilot on a serial port.
#include <poll.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/app/linux/link_report.h"
#include "firmware/app/linux/subcommands.h"
#include "firmware/app/serial_link.h"
#include "hal/linux/monotonic_clock.h"
#include "hal/linux/serial_port.h"
#include "protocol/aes256.h"

namespace m100::app {
namespace {

volatile std::sig_atomic_t stop_asked = 0;
void ask_to_stop(int) { stop_asked = 1; }

struct Options {
  std::string port;
  std::uint32_t baud = 230400;
  std::uint32_t app_id = 0;
  std::string key_file;
  std::string channel = "virtual_rc";
  double rate_hz = 0.0;
  bool paper_100_hz = false;
  bool dry_run = false;
  bool take_control = false;
  double hold_s = 5.0;
  double patience_s = 30.0;
  std::string json;
};

protocol::CipherKey read_key(const std::string& path) {
  std::ifstream file(path);
  std::string hex;
  file >> hex;
  protocol::CipherKey key{};
  if (hex.size() != 2 * key.size() || hex.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos) {
    throw UsageError(path + ":1: the key needs 64 hexadecimal digits");
  }
  for (std::size_t i = 0; i < key.size(); ++i) {
    key[i] = static_cast<std::uint8_t>(std::stoul(hex.substr(2 * i, 2), nullptr, 16));
  }
  return key;
}

LinkConfig link_config(const Options& options) {
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

struct Change {
  core::TimePoint at;
  safety::Stage stage;
  safety::Reason reason;
};

/// The course of one session at the autopilot: start-up, control, neutral commands, release. In a dry run the program
/// is started to do all of it once; else the operator asks and releases by the keys Enter and q.
class Session {
 public:
  Session(const Options& options, SerialLink& link) : options_(options), link_(link) {}

  /// One tick. @returns false: over.
  bool tick(core::TimePoint now) {
    link_.receive(now);
    note_changes(now);
    const AuthorityView& authority = link_.authority();
    if (authority.in_control) {
      obtained_at_ = obtained_ ? obtained_at_ : now;
      obtained_ = true;
      (void)link_.send(neutral(), now);
    }
    if (phase_ == Phase::kStarting && authority.stage == safety::Stage::kReady && wants_control()) {
      link_.request_control(now);
      phase_ = Phase::kAsked;
      asked_at_ = now;
    } else if (phase_ == Phase::kAsked && authority.in_control) {
      phase_ = Phase::kHolding;
    } else if (phase_ == Phase::kAsked && was_refused(now)) {
      return false;
    } else if (phase_ == Phase::kHolding && !authority.in_control) {
      return false;  // lost: nothing is sent any more, and nobody asks again
    } else if (phase_ == Phase::kHolding && wants_release(now)) {
      link_.release(now);
      phase_ = Phase::kReleasing;
      release_at_ = now;
    } else if (phase_ == Phase::kReleasing && authority.stage != safety::Stage::kReleasing &&
               now > release_at_ + kStep) {
      released_ = authority.reason == safety::Reason::kReleased;
      return false;
    }
    const bool too_long = phase_ == Phase::kStarting && options_.dry_run && seconds(now) > options_.patience_s;
    return !too_long && !(stop_asked != 0 && phase_ != Phase::kHolding && phase_ != Phase::kReleasing);
  }

  bool succeeded() const { return released_; }
  bool obtained() const { return obtained_; }
  const std::vector<Change>& changes() const { return changes_; }

 private:
  enum class Phase { kStarting, kAsked, kHolding, kReleasing };
  static constexpr core::Duration kStep = core::kTickPeriod;

  static double seconds(core::TimePoint at) { return core::seconds<double>(at.time_since_epoch()); }

  ChannelCommand neutral() const {
    return options_.channel == "movement" ? ChannelCommand(ctl::Command<double>{}) : ChannelCommand(vrc::Sticks{});
  }

  /// Enter was pressed, or the program was started for it.
  bool wants_control() { return options_.dry_run || options_.take_control || key_pressed(); }
  bool wants_release(core::TimePoint now) {
    const bool held = options_.dry_run && now - obtained_at_ >= core::Duration{std::int64_t(options_.hold_s * 1e6)};
    return held || stop_asked != 0 || (!options_.dry_run && key_pressed());
  }
  static bool key_pressed() {
    pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
    char line[64];
    return poll(&input, 1, 0) > 0 && read(STDIN_FILENO, line, sizeof line) > 0;
  }
  /// The table has gone back to a stage that waits for the operator.
  bool was_refused(core::TimePoint now) const {
    const safety::Stage stage = link_.authority().stage;
    const bool waits =
        stage == safety::Stage::kReady || stage == safety::Stage::kSilent || stage == safety::Stage::kSilentCold;
    return waits && now - asked_at_ > 2 * safety::kRequestSpacing;
  }
  void note_changes(core::TimePoint now) {
    const AuthorityView& authority = link_.authority();
    if (!changes_.empty() && changes_.back().stage == authority.stage && changes_.back().reason == authority.reason) {
      return;
    }
    changes_.push_back({now, authority.stage, authority.reason});
    std::cout << seconds(now) << " s  " << safety::name(authority.stage) << " (" << safety::name(authority.reason)
              << ")";
    const bool answered = authority.reason == safety::Reason::kAnswer;
    const std::string_view remedy = answered ? authority.answer.remedy : safety::remedy(authority.reason);
    std::cout << (answered ? ": " + std::string(authority.answer.name) : "")
              << (remedy.empty() ? "" : "; " + std::string(remedy)) << std::endl;
  }

  const Options& options_;
  SerialLink& link_;
  Phase phase_ = Phase::kStarting;
  bool obtained_ = false;
  core::TimePoint obtained_at_{};
  core::TimePoint asked_at_{};
  core::TimePoint release_at_{};
  bool released_ = false;
  std::vector<Change> changes_;
};

std::string to_json(const Options& options, const Session& session, const SerialLink& link, std::uint32_t stalls) {
  std::ostringstream out;
  out << "{\"channel\":" << quoted(options.channel) << ",\"baud\":" << options.baud
      << ",\"obtained\":" << (session.obtained() ? "true" : "false")
      << ",\"released\":" << (session.succeeded() ? "true" : "false")
      << ",\"last_stage\":" << quoted(safety::name(link.authority().stage))
      << ",\"last_reason\":" << quoted(safety::name(link.authority().reason))
      << ",\"firmware\":" << quoted(protocol::text(link.version().version_name)) << ",\"stalls\":" << stalls
      << ",\"stages\":[";
  for (std::size_t i = 0; i < session.changes().size(); ++i) {
    const Change& change = session.changes()[i];
    out << (i == 0 ? "" : ",") << "{\"t_s\":" << core::seconds<double>(change.at.time_since_epoch())
        << ",\"stage\":" << quoted(safety::name(change.stage)) << ",\"reason\":" << quoted(safety::name(change.reason))
        << "}";
  }
  out << "],\"health\":" << to_json(link.health()) << "}";
  return out.str();
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
      throw UsageError(port.path() + ": no such serial port");
  }
}

void run(const Options& options) {
  if (!options.dry_run) {
    throw UsageError("fly: without a pose only --dry-run flies (neutral commands from start-up to release)");
  }
  LinkConfig config = link_config(options);
  std::optional<protocol::Aes256> cipher;
  if (!options.key_file.empty()) {
    cipher.emplace(read_key(options.key_file));
    config.cipher = &*cipher;
    config.encrypt_commands = true;
  }
  hal::SerialPort port(options.port, options.baud);
  open_or_explain(port);
  std::signal(SIGINT, ask_to_stop);
  std::signal(SIGTERM, ask_to_stop);
  hal::MonotonicClock clock;
  SerialLink link(port, config);
  Session session(options, link);
  std::uint32_t stalls = 0;
  core::TimePoint deadline = clock.now();
  core::TimePoint last = deadline;
  for (core::TimePoint now = deadline; session.tick(now); now = clock.now()) {
    stalls += now - last > 2 * core::kTickPeriod ? 1U : 0U;
    last = now;
    deadline = now - deadline > core::kTickPeriod ? now + core::kTickPeriod : deadline + core::kTickPeriod;
    clock.sleep_until(deadline);
  }
  std::cout << (session.succeeded() ? "released" : "not completed") << "\n";
  print(std::cout, link.health());
  if (!options.json.empty()) {
    write_file(options.json, to_json(options, session, link, stalls));
  }
  if (!session.succeeded()) {
    throw CLI::RuntimeError(kAnswerIsNo);
  }
}

}  // namespace

void add_fly(CLI::App& m100) {
  CLI::App* app = m100.add_subcommand("fly", "take control of the autopilot at a serial port, and give it back");
  auto options = std::make_shared<Options>();
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
  app->add_flag("--take-control", options->take_control, "ask for control once as soon as all is ready");
  app->add_option("--hold", options->hold_s, "seconds in control in a dry run")->check(CLI::Range(0.0, 3600.0));
  app->add_option("--patience", options->patience_s, "seconds to wait for start-up in a dry run")
      ->check(CLI::Range(1.0, 3600.0));
  app->add_option("--json", options->json, "result as JSON");
  app->callback([options] { run(*options); });
}

}  // namespace m100::app
