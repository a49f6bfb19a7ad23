// SPDX-License-Identifier: BSD-3-Clause
// m100 doctor: finds what on this board may prevent a flight, and the remedy for each; and m100 probe, its part that
// listens to the autopilot's port.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/text/json.h"
#include "firmware/companion/files/text/printable.h"
#include "firmware/companion/operator/link_report.h"
#include "firmware/companion/preflight/board_checks.h"
#include "firmware/companion/preflight/check_result.h"
#include "firmware/companion/preflight/pose_checks.h"
#include "firmware/companion/preflight/probe/line_check.h"
#include "firmware/companion/preflight/serial_ports.h"
#include "firmware/companion/preflight/wake_up_check.h"
#include "hal/linux/udp_port.h"

namespace m100::companion {
namespace {

struct DoctorOptions {
  std::string port;
  std::uint32_t baud = 0;  ///< 0: every rate that DJI supports
  double listen_s = 2.0;   ///< at each baud rate
  std::string folder = ".";
  std::string json;
  preflight::PosePlan pose;
  double load_s = 5.0;
  bool frames = false;
  double hold_s = 30.0;
};

using preflight::CheckResult;
using preflight::Health;

const char* word(Health health) {
  return health == Health::kGood ? "good" : health == Health::kDoubtful ? "doubtful" : "bad";
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

std::vector<std::string> ports_of(const DoctorOptions& options) {
  return options.port.empty() ? serial_ports() : std::vector<std::string>{options.port};
}

/// What `m100 probe` tells, and the vibration at the rate that it finds.
PortVerdict check_line(const DoctorOptions& options, std::vector<CheckResult>& checks) {
  const PortVerdict found = search_line({options.port}, options.baud, options.listen_s);
  const bool is_autopilot = found.verdict == Verdict::kAutopilot;
  if (found.verdict != Verdict::kCannotOpen) {  // the port's own check says why
    checks.push_back(
        {"line " + options.port, is_autopilot ? Health::kGood : Health::kBad, describe(found), remedy_of(found)});
  }
  checks.push_back(preflight::check_vibration(options.port, found.baud));
  return found;
}

std::vector<CheckResult> examine(const DoctorOptions& options, std::optional<PortVerdict>& line) {
  std::vector<CheckResult> checks;
  const std::vector<std::string> ports = ports_of(options);
  if (ports.empty()) {
    checks.push_back({"port", Health::kBad, "no serial port on this machine", "plug in the adapter to UART_CAN2"});
  }
  for (const std::string& port : ports) {
    checks.push_back(preflight::check_port(port));
    checks.push_back(preflight::check_adapter(port));
  }
  if (!options.port.empty()) {
    line = check_line(options, checks);
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
  const std::vector<CheckResult> poses = preflight::check_pose_port(options.pose, options.port);
  checks.insert(checks.end(), poses.begin(), poses.end());
  return checks;
}

Json to_json(const std::vector<CheckResult>& checks) {
  Json all = Json::array();
  for (const CheckResult& check : checks) {
    all.push_back(
        {{"name", check.name}, {"health", word(check.health)}, {"finding", check.finding}, {"remedy", check.remedy}});
  }
  return {{"checks", all}};
}

std::vector<CheckResult> check_by_hand(const DoctorOptions& options) {
  constexpr std::uint32_t kUsualBaud = 230400;
  return preflight::check_frames(options.port, options.baud != 0 ? options.baud : kUsualBaud, options.pose.source,
                                 options.hold_s);
}

void run_probe(const DoctorOptions& options) {
  FileUse().holds("--port", options.port).writes("--json", options.json).check();
  const std::vector<std::string> ports = ports_of(options);
  if (ports.empty()) {
    throw UsageError("no serial port on this machine: name one with --port");
  }
  const PortVerdict best = search_line(ports, options.baud, options.listen_s);
  std::cout << "port " << printable(best.port) << ", " << describe(best) << "\n";
  if (best.has_autopilot()) {
    print(std::cout, best.health);
  }
  if (!options.json.empty()) {
    write_json(options.json, companion::to_json(best));
  }
  const std::string remedy = remedy_of(best);
  if (best.verdict == Verdict::kCannotOpen && !options.port.empty()) {
    throw UsageError(best.port + ": " + remedy);
  }
  if (!remedy.empty()) {
    std::cout << "remedy: " << printable(remedy + holders_note(best.port)) << "\n";
  }
  if (best.verdict != Verdict::kAutopilot) {
    throw AnswerIsNo();
  }
}

void run(const DoctorOptions& options) {
  FileUse()
      .holds("--port", options.port)
      .holds("--mavlink-key", options.pose.source.key_file)  // whether it can be read is one of the answers
      .writes("--json", options.json)
      .check();
  std::optional<PortVerdict> line;
  const std::vector<CheckResult> checks = options.frames ? check_by_hand(options) : examine(options, line);
  bool bad = false;
  for (const CheckResult& check : checks) {
    std::cout << word(check.health) << ": " << printable(check.name) << ": " << printable(check.finding) << "\n";
    if (!check.remedy.empty()) {
      std::cout << "  remedy: " << printable(check.remedy) << "\n";
    }
    bad = bad || check.health == Health::kBad;
  }
  if (line && line->has_autopilot()) {
    print(std::cout, line->health);
  }
  if (!options.json.empty()) {
    Json out = to_json(checks);
    if (line) {
      out.update(companion::to_json(*line));
    }
    write_json(options.json, out);
  }
  if (bad) {
    throw AnswerIsNo();
  }
}

/// The options of both commands.
void add_line_options(const Subcommand& app, DoctorOptions& options, const std::string& port) {
  app.add_option("--port", options.port, port);
  app.add_option("--baud", options.baud,
                 "baud rate of the autopilot, as set in DJI's assistant; 0: every rate that DJI supports")
      .one_of({115200, 230400, 460800, 921600});
  app.add_option("--seconds", options.listen_s, "seconds to listen at each baud rate").in_range(0.1, 60.0);
  app.add_option("--json", options.json, "result as JSON");
}

}  // namespace

void add_probe(CommandLine& m100) {
  const auto [app, options] = m100.add_subcommand<DoctorOptions>(
      "probe", "listen only: find port and baud rate, or name what is wrong; doctor --port does it too", run_probe);
  add_line_options(app, *options, "serial port; default: every port that looks like one");
}

void add_doctor(CommandLine& m100) {
  const auto [app, options] =
      m100.add_subcommand<DoctorOptions>("doctor", "find what on this board prevents a flight; print remedies", run);
  add_line_options(app, *options,
                   "serial port of the autopilot; m100 listens there, tells what m100 probe tells, and measures the "
                   "vibration for four seconds; default: every port that looks like one, without listening for an "
                   "autopilot");
  app.add_option("--folder", options->folder, "where flight logs go");
  app.add_option("--load", options->load_s,
                 "seconds in which every processor and the disk are kept busy while the lateness of ticks is measured; "
                 "0: not measured")
      .in_range(0.0, 600.0);
  // A line may be planned at a baud rate that no port of this board has.
  add_pose_options(app, options->pose.source, /*any_baud=*/true);
  app.add_option("--pose-message", options->pose.message, "the message in which poses will come")
      .one_of(preflight::pose_messages());
  app.add_option("--pose-rate", options->pose.rate_hz, "poses per second").in_range(1.0, 1000.0);
  app.add_flag(
      "--frames", options->frames,
      "propellers off: move the aircraft by hand; m100 says which axis of the pose disagrees with the autopilot's "
      "attitude and specific force; needs --port and --pose-port, and listens at 230400 baud without --baud. Example: "
      "m100 doctor --frames --port /dev/ttyUSB0 "
      "--pose-port udp:14560 --mavlink-key mavlink.key");
  app.add_option("--hold", options->hold_s, "with --frames: seconds to move the aircraft")
      .in_range(1.0, 600.0)
      .needs("--frames");
}

}  // namespace m100::companion
