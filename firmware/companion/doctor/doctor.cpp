// SPDX-License-Identifier: BSD-3-Clause
// m100 doctor: what on this board may stand in the way of a flight, and the remedy for each.
#include <sched.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <time.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/companion/doctor/check.h"
#include "firmware/companion/doctor/frames.h"
#include "firmware/companion/doctor/pose_checks.h"
#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/printable.h"
#include "firmware/companion/fly/link_report.h"
#include "firmware/companion/fly/ports.h"
#include "firmware/companion/subcommands.h"
#include "hal/linux/monotonic_clock.h"
#include "hal/linux/serial_port.h"
#include "hal/linux/udp_port.h"

namespace m100::companion {
namespace {

namespace fs = std::filesystem;

struct DoctorOptions {
  std::string port;
  std::string folder = ".";
  std::string json;
  doctor::PoseLine pose;
  bool frames = false;
  doctor::FramesOptions by_hand;
};

using doctor::Check;
using doctor::Health;

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

std::string first_line(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

/// Read from the file: getgrgid() would pull shared libraries into the static binary.
std::string owner_group(const std::string& port) {
  struct stat status {};
  if (stat(port.c_str(), &status) == 0) {
    std::ifstream groups("/etc/group");
    for (std::string line; std::getline(groups, line);) {  // name:password:number:members
      std::istringstream fields(line);
      std::string name, password, number;
      std::getline(fields, name, ':');
      std::getline(fields, password, ':');
      std::getline(fields, number, ':');
      if (number == std::to_string(status.st_gid)) {
        return name;
      }
    }
  }
  return "dialout";
}

Check check_port(const std::string& path) {
  Check check{.name = "port " + path, .health = Health::kBad, .finding = "", .remedy = ""};
  if (access(path.c_str(), F_OK) != 0) {
    check.finding = "does not exist";
    check.remedy = "plug the adapter in; dmesg shows under which name it appears";
    return check;
  }
  if (access(path.c_str(), R_OK | W_OK) != 0) {
    check.finding = "no right to read and write";
    const std::string group = owner_group(path);
    check.remedy = group == "root"  // whose group gives far more than a port
                       ? "install the package's udev rules (60-m100.rules) and plug the adapter in again"
                       : "sudo usermod -aG " + group + " $USER, then log in again";
    return check;
  }
  hal::SerialPort port(path, 230400);
  switch (port.open()) {
    case core::Status::kOk:
      check.health = Health::kGood;
      check.finding = "opens at 230400 baud, raw 8N1";
      break;
    case core::Status::kRefused:
      check.finding = "another program holds it";
      check.remedy = "sudo fuser -v " + path + " names it; ModemManager: sudo systemctl disable --now ModemManager";
      break;
    default:
      check.finding = "is not a serial port, or does not take 230400 baud";
      check.remedy = "name another one with --port";
  }
  return check;
}

/// FTDI adapters collect bytes for 16 ms unless told otherwise: more than one control period.
Check check_adapter(const std::string& path) {
  std::error_code error;
  const fs::path device = fs::canonical(path, error).filename();
  const fs::path timer = fs::path("/sys/class/tty") / device / "device/latency_timer";
  const std::string value = first_line(timer);
  if (value.empty()) {
    return {"adapter latency " + path, Health::kGood, "no latency timer (not an FTDI adapter)", ""};
  }
  const bool short_enough = value == "1" || value == "0" || value == "2";
  return {"adapter latency " + path, short_enough ? Health::kGood : Health::kBad, value + " ms",
          short_enough ? "" : "echo 1 | sudo tee " + timer.string() + " (for good: a udev rule)"};
}

Check check_real_time() {
  constexpr rlim_t kNeeded = 64U << 20U;  // of memory that is locked: the program, its log's ring, a second stack
  rlimit memory{};
  getrlimit(RLIMIT_MEMLOCK, &memory);
  const sched_param wanted{.sched_priority = 1};
  const int former = sched_getscheduler(0);
  const sched_param normal{.sched_priority = 0};
  const bool granted = sched_setscheduler(0, SCHED_FIFO, &wanted) == 0;
  if (granted) {
    sched_setscheduler(0, former, &normal);
    if (geteuid() == 0 || memory.rlim_cur >= kNeeded) {
      return {"real-time rights", Health::kGood, "SCHED_FIFO is granted", ""};
    }
  }
  return {"real-time rights", Health::kDoubtful, granted ? "memory cannot be locked" : "SCHED_FIFO is refused",
          "add '@realtime - rtprio 80' and '@realtime - memlock unlimited' to /etc/security/limits.d/m100.conf, and "
          "yourself to that group"};
}

Check check_clock() {
  constexpr int kTicks = 50;
  constexpr std::int64_t kGood_us = 1000, kBad_us = 5000;
  hal::MonotonicClock clock;
  std::vector<std::int64_t> lateness_us;
  core::TimePoint deadline = clock.now();
  for (int i = 0; i < kTicks; ++i) {
    deadline += core::kTickPeriod;
    clock.sleep_until(deadline);
    lateness_us.push_back((clock.now() - deadline).count());
  }
  const std::int64_t worst_us = *std::max_element(lateness_us.begin(), lateness_us.end());
  std::ostringstream finding;
  finding << "ticks of 10 ms are up to " << worst_us << " us late (" << kTicks << " ticks)";
  const Health health = worst_us <= kGood_us ? Health::kGood : worst_us <= kBad_us ? Health::kDoubtful : Health::kBad;
  return {
      "clock", health, finding.str(),
      health == Health::kGood ? "" : "stop other programs; set the governor to performance; grant real-time rights"};
}

Check check_governor() {
  const std::string governor = first_line("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
  if (governor.empty()) {
    return {"processor clock", Health::kGood, "does not change", ""};
  }
  const bool steady = governor == "performance";
  return {"processor clock", steady ? Health::kGood : Health::kDoubtful, "governor " + governor,
          steady ? "" : "sudo cpupower frequency-set -g performance"};
}

Check check_disk(const std::string& folder) {
  constexpr double kMegabyte = 1e6;
  constexpr double kGood_MB = 500.0, kBad_MB = 50.0;  // a flight of 20 minutes takes about 40 MB
  struct statvfs status {};
  if (statvfs(folder.c_str(), &status) != 0 || access(folder.c_str(), W_OK) != 0) {
    return {"disk " + folder, Health::kBad, "cannot be written", "name another folder with --folder"};
  }
  const double free_MB = static_cast<double>(status.f_bavail) * static_cast<double>(status.f_frsize) / kMegabyte;
  std::ostringstream finding;
  finding << static_cast<std::int64_t>(free_MB) << " MB free";
  const Health health = free_MB >= kGood_MB ? Health::kGood : free_MB >= kBad_MB ? Health::kDoubtful : Health::kBad;
  return {"disk " + folder, health, finding.str(), health == Health::kGood ? "" : "delete old flight logs"};
}

std::vector<Check> examine(const DoctorOptions& options) {
  std::vector<Check> checks;
  const std::vector<std::string> ports = options.port.empty() ? serial_ports() : std::vector<std::string>{options.port};
  if (ports.empty()) {
    checks.push_back({"port", Health::kBad, "no serial port on this machine", "plug in the adapter to UART_CAN2"});
  }
  for (const std::string& port : ports) {
    checks.push_back(check_port(port));
    checks.push_back(check_adapter(port));
  }
  checks.push_back(check_real_time());
  checks.push_back(check_clock());
  checks.push_back(check_governor());
  checks.push_back(check_disk(options.folder));
  if (!hal::is_udp(options.pose.port)) {
    checks.push_back(doctor::check_pose_line(options.pose));
  }
  const std::vector<Check> poses = doctor::check_pose_port(options.pose);
  checks.insert(checks.end(), poses.begin(), poses.end());
  return checks;
}

nlohmann::json to_json(const std::vector<Check>& checks) {
  nlohmann::json all = nlohmann::json::array();
  for (const Check& check : checks) {
    all.push_back(
        {{"name", check.name}, {"health", word(check.health)}, {"finding", check.finding}, {"remedy", check.remedy}});
  }
  return {{"checks", all}};
}

doctor::FramesOptions by_hand_of(const DoctorOptions& options) {
  doctor::FramesOptions by_hand = options.by_hand;
  by_hand.port = options.port;
  by_hand.pose = {.port = options.pose.port,
                  .baud = static_cast<std::uint32_t>(options.pose.baud),
                  .key_file = options.pose.key_file};
  return by_hand;
}

void run(const DoctorOptions& options) {
  for (const auto& [name, value] : {std::pair{"--pose-rate", options.pose.rate_hz},
                                    {"--pose-baud", options.pose.baud},
                                    {"--hold", options.by_hand.hold_s}}) {
    if (std::isnan(value)) {  // passes every comparison of a range
      throw UsageError(std::string(name) + ": is not a number");
    }
  }
  FileUse()
      .holds("--port", options.port)
      .holds("--mavlink-key", options.pose.key_file)  // whether it can be read is one of the answers
      .writes("--json", options.json)
      .check();
  const std::vector<Check> checks = options.frames ? doctor::check_frames(by_hand_of(options)) : examine(options);
  bool bad = false;
  for (const Check& check : checks) {
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
  CLI::App* app =
      m100.add_subcommand("doctor", "find what on this board stands in the way of a flight; print remedies");
  auto options = std::make_shared<DoctorOptions>();
  app->add_option("--port", options->port, "serial port; default: all that look like one");
  app->add_option("--folder", options->folder, "where flight logs go");
  app->add_option("--pose-port", options->pose.port,
                  "where poses come from: a serial port, or udp:PORT, which needs --mavlink-key; listens there for two "
                  "seconds; default: not looked at. Example: udp:14560");
  app->add_option("--mavlink-key", options->pose.key_file,
                  "file with the key of the signatures, as in m100 fly; default: none. Example: mavlink.key");
  app->add_option("--pose-message", options->pose.message, "the message in which poses will come")
      ->check(CLI::IsMember(doctor::pose_messages()));
  app->add_option("--pose-rate", options->pose.rate_hz, "poses per second")->check(CLI::Range(1.0, 1000.0));
  app->add_option("--pose-baud", options->pose.baud, "baud rate of their line")->check(CLI::Range(1200.0, 4e6));
  CLI::Option* const frames = app->add_flag(
      "--frames", options->frames,
      "propellers off: move the aircraft by hand, and be told which axis of the pose is wrong against the autopilot's "
      "attitude and specific force; needs --port and --pose-port. Example: m100 doctor --frames --port /dev/ttyUSB0 "
      "--pose-port udp:14560 --mavlink-key mavlink.key");
  app->add_option("--baud", options->by_hand.baud, "with --frames: of the autopilot, as set in DJI's assistant")
      ->check(CLI::IsMember({115200, 230400, 460800, 921600}))
      ->needs(frames);
  app->add_option("--hold", options->by_hand.hold_s, "with --frames: seconds to move it")
      ->check(CLI::Range(1.0, 600.0))
      ->needs(frames);
  app->add_option("--json", options->json, "result as JSON");
  app->callback([options] { run(*options); });
}

}  // namespace m100::companion
