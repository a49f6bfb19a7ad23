// SPDX-License-Identifier: BSD-3-Clause
// m100 doctor: finds what on this board may prevent a flight, and the remedy for each.
#include "firmware/companion/preflight/doctor.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/text/printable.h"
#include "firmware/companion/operator/link_report.h"
#include "firmware/companion/preflight/board_checks.h"
#include "firmware/companion/preflight/check_frames.h"
#include "firmware/companion/preflight/check_result.h"
#include "firmware/companion/preflight/pose_checks.h"
#include "firmware/companion/preflight/probe/vibration_check.h"
#include "firmware/companion/preflight/serial_ports.h"
#include "firmware/companion/preflight/wake_up_check.h"
#include "hal/linux/udp_port.h"

namespace m100::companion {
namespace {

struct DoctorOptions {
  std::string port;
  std::string folder = ".";
  std::string json;
  preflight::PosePlan pose;
  double load_s = 5.0;
  bool frames = false;
  preflight::CheckFramesOptions by_hand;
};

using preflight::CheckResult;
using preflight::Health;

const char* word(Health health) {
  switch (health) {
    case Health::kGood:
      return "good";
    case Health::kDoubtful:
      return "doubtful";
    case Health::kBad:
      break;
  }
  return "bad";
}

/// Measures under load, unless another program holds a port: it may be flying.
CheckResult check_under_load(std::span<const CheckResult> so_far, const DoctorOptions& options) {
  const auto is_held = [](const CheckResult& check) { return check.finding.starts_with(preflight::kHeldByAnother); };
  if (std::any_of(so_far.begin(), so_far.end(), is_held)) {
    return {"wake-up under load", Health::kDoubtful, "not measured, because another program holds a port",
            "end that program and run m100 doctor again"};
  }
  const auto duration = std::chrono::duration_cast<core::Duration>(std::chrono::duration<double>(options.load_s));
  return preflight::judge_wake_ups(preflight::measure_wake_ups(options.folder, duration));
}

std::vector<CheckResult> examine(const DoctorOptions& options) {
  std::vector<CheckResult> checks;
  const std::vector<std::string> ports = options.port.empty() ? serial_ports() : std::vector<std::string>{options.port};
  if (ports.empty()) {
    checks.push_back({"port", Health::kBad, "no serial port on this machine", "plug in the adapter to UART_CAN2"});
  }
  for (const std::string& port : ports) {
    checks.push_back(preflight::check_port(port));
    checks.push_back(preflight::check_adapter(port));
  }
  if (!options.port.empty()) {
    checks.push_back(preflight::check_vibration(options.port, options.by_hand.baud));
  }
  checks.push_back(preflight::check_real_time());
  checks.push_back(preflight::check_clock());
  checks.push_back(preflight::check_governor());
  checks.push_back(preflight::check_disk(options.folder));
  if (options.load_s > 0.0) {
    checks.push_back(check_under_load(checks, options));
  }
  if (!hal::is_udp(options.pose.source.port)) {
    checks.push_back(preflight::check_pose_line(options.pose));
  }
  preflight::PosePlan pose = options.pose;
  pose.autopilot_port = options.port;
  const std::vector<CheckResult> poses = preflight::check_pose_port(pose);
  checks.insert(checks.end(), poses.begin(), poses.end());
  return checks;
}

nlohmann::json to_json(const std::vector<CheckResult>& checks) {
  nlohmann::json all = nlohmann::json::array();
  for (const CheckResult& check : checks) {
    all.push_back(
        {{"name", check.name}, {"health", word(check.health)}, {"finding", check.finding}, {"remedy", check.remedy}});
  }
  return {{"checks", all}};
}

preflight::CheckFramesOptions by_hand_of(const DoctorOptions& options) {
  preflight::CheckFramesOptions by_hand = options.by_hand;
  by_hand.port = options.port;
  by_hand.pose = options.pose.source;
  return by_hand;
}

void run(const DoctorOptions& options) {
  for (const auto& [name, value] : {std::pair{"--pose-rate", options.pose.rate_hz},
                                    {"--load", options.load_s},
                                    {"--hold", options.by_hand.hold_s}}) {
    if (std::isnan(value)) {  // CLI11's range check accepts it
      throw UsageError(std::string(name) + ": is not a number");
    }
  }
  FileUse()
      .holds("--port", options.port)
      .holds("--mavlink-key", options.pose.source.key_file)  // whether it can be read is one of the answers
      .writes("--json", options.json)
      .check();
  const std::vector<CheckResult> checks =
      options.frames ? preflight::check_frames(by_hand_of(options)) : examine(options);
  bool bad = false;
  for (const CheckResult& check : checks) {
    std::cout << word(check.health) << ": " << printable(check.name) << ": " << printable(check.finding) << "\n";
    if (!check.remedy.empty()) {
      std::cout << "  remedy: " << printable(check.remedy) << "\n";
    }
    bad = bad || check.health == Health::kBad;
  }
  if (!options.json.empty()) {
    write_json(options.json, to_json(checks));
  }
  if (bad) {
    throw CLI::RuntimeError(kAnswerIsNo);
  }
}

}  // namespace

void add_doctor(CLI::App& m100) {
  CLI::App* app = m100.add_subcommand("doctor", "find what on this board prevents a flight; print remedies");
  auto options = std::make_shared<DoctorOptions>();
  app->add_option("--port", options->port,
                  "serial port; m100 listens there for four seconds and measures the vibration; default: every port "
                  "that looks like one, without vibration");
  app->add_option("--folder", options->folder, "where flight logs go");
  app->add_option(
         "--load", options->load_s,
         "seconds in which every processor and the disk are kept busy while the lateness of ticks is measured; "
         "0: not measured")
      ->check(CLI::Range(0.0, 600.0));
  // A line may be planned at a baud rate that no port of this board has.
  add_pose_options(*app, options->pose.source, CLI::Range(1200, 4000000));
  app->add_option("--pose-message", options->pose.message, "the message in which poses will come")
      ->check(CLI::IsMember(preflight::pose_messages()));
  app->add_option("--pose-rate", options->pose.rate_hz, "poses per second")->check(CLI::Range(1.0, 1000.0));
  CLI::Option* const frames = app->add_flag(
      "--frames", options->frames,
      "propellers off: move the aircraft by hand; m100 says which axis of the pose disagrees with the autopilot's "
      "attitude and specific force; needs --port and --pose-port. Example: m100 doctor --frames --port /dev/ttyUSB0 "
      "--pose-port udp:14560 --mavlink-key mavlink.key");
  app->add_option("--baud", options->by_hand.baud, "baud rate of the autopilot, as set in DJI's assistant")
      ->check(CLI::IsMember({115200, 230400, 460800, 921600}));
  app->add_option("--hold", options->by_hand.hold_s, "with --frames: seconds to move the aircraft")
      ->check(CLI::Range(1.0, 600.0))
      ->needs(frames);
  app->add_option("--json", options->json, "result as JSON");
  app->callback([options] { run(*options); });
}

}  // namespace m100::companion
