// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/preflight/board_checks.h"

#include <sched.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "firmware/companion/preflight/probe/line_check.h"
#include "firmware/companion/preflight/serial_ports.h"
#include "hal/linux/monotonic_clock.h"
#include "hal/linux/serial_port.h"

namespace m100::companion::preflight {
namespace {

namespace fs = std::filesystem;

std::string first_line(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

/// The port's group; "dialout" if it is unknown. Read from /etc/group, because the C library would pull shared
/// libraries into the static binary.
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

/// Judges a port that opens: whether it is the pose's, and whether another program takes the bytes.
void judge_line(const std::string& path, CheckResult& check) {
  constexpr std::uint32_t kUsualPoseBaud = 115200;
  constexpr double kListen_s = 0.5;
  const std::string others = holders_note(path);
  Verdict heard = listen(path, 230400, kListen_s).verdict;
  if (heard == Verdict::kWrongBaud || heard == Verdict::kNoAutopilot) {
    heard = listen(path, kUsualPoseBaud, kListen_s).verdict == Verdict::kPosePort ? Verdict::kPosePort : heard;
  }
  check.finding += others;
  if (heard == Verdict::kPosePort) {
    check.health = Health::kBad;
    check.finding += "; MAVLink poses come at this port";
    check.remedy = remedy(heard);
  } else if (!others.empty() && (heard == Verdict::kNothingReceived || heard == Verdict::kNoisy)) {
    check.health = Health::kBad;
    check.finding += heard == Verdict::kNoisy ? "; many frames are damaged" : "; not one byte came";
    check.remedy =
        "end the other program; ModemManager: sudo systemctl disable --now ModemManager; a login on the "
        "port: sudo systemctl disable --now serial-getty@...";
  }
}

}  // namespace

CheckResult check_port(const std::string& path) {
  CheckResult check{.name = "port " + path, .health = Health::kBad, .finding = "", .remedy = ""};
  if (access(path.c_str(), F_OK) != 0) {
    check.finding = "does not exist";
    check.remedy = missing_port_remedy(path);
    return check;
  }
  if (access(path.c_str(), R_OK | W_OK) != 0) {
    check.finding = "no permission to read and write";
    const std::string group = owner_group(path);
    check.remedy = group == "root"  // membership of root would permit far more than a port
                       ? "install the package's udev rules (60-m100.rules) and plug the adapter in again"
                       : "sudo usermod -aG " + group + " $USER, then log in again";
    return check;
  }
  hal::SerialPort port(path, 230400);
  switch (port.open()) {
    case core::Status::kOk:
      check.health = Health::kGood;
      check.finding = "opens at 230400 baud, raw 8N1";
      port.close();
      judge_line(path, check);
      break;
    case core::Status::kRefused:
      check.finding = kHeldByAnother + holders_note(path);
      check.remedy = "sudo fuser -v " + path + " names it; ModemManager: sudo systemctl disable --now ModemManager";
      break;
    default:
      check.finding = "is not a serial port, or does not take 230400 baud";
      check.remedy = "name another one with --port";
  }
  return check;
}

CheckResult check_adapter(const std::string& path) {
  std::error_code error;
  const fs::path device = fs::canonical(path, error).filename();
  const fs::path timer = fs::path("/sys/class/tty") / device / "device/latency_timer";
  const std::string value = first_line(timer);
  if (value.empty()) {
    return {"adapter latency " + path, Health::kGood, "no latency timer (not an FTDI adapter)", ""};
  }
  const bool short_enough = value == "1" || value == "0" || value == "2";
  return {"adapter latency " + path, short_enough ? Health::kGood : Health::kBad, value + " ms",
          short_enough ? "" : "echo 1 | sudo tee " + timer.string() + " (permanently: a udev rule)"};
}

CheckResult check_real_time() {
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
          "add yourself to the group realtime"};
}

CheckResult check_clock() {
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

CheckResult check_governor() {
  const std::string governor = first_line("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
  if (governor.empty()) {
    return {"processor clock", Health::kGood, "no frequency scaling", ""};
  }
  const bool steady = governor == "performance";
  return {"processor clock", steady ? Health::kGood : Health::kDoubtful, "governor " + governor,
          steady ? "" : "sudo cpupower frequency-set -g performance"};
}

CheckResult check_disk(const std::string& folder) {
  constexpr double kMegabyte = 1e6;
  constexpr double kGood_MB = 500.0, kBad_MB = 100.0;  // a flight of 20 minutes takes 80 to 100 MB
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

}  // namespace m100::companion::preflight
