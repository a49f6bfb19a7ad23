// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/preflight/serial_ports.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <set>
#include <string_view>

namespace m100::companion {
namespace {

namespace fs = std::filesystem;
/// USB adapters, then the UARTs of Jetson, i.MX and Raspberry Pi boards.
constexpr std::array<std::string_view, 6> kPrefixes{"ttyUSB", "ttyACM", "ttyTHS", "ttymxc", "ttyAMA", "ttyS"};

std::vector<fs::path> listing(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    entries.push_back(entry->path());
  }
  std::sort(entries.begin(), entries.end());
  return entries;
}

int parent_of(const fs::path& process) {
  std::ifstream status(process / "status");
  for (std::string key; status >> key;) {
    if (int parent = 0; key == "PPid:" && status >> parent) {
      return parent;
    }
  }
  return 0;
}

/// The kernel creates /dev/ttyS0..3 even without hardware; those have no driver's device.
bool has_hardware(const fs::path& port) {
  std::error_code error;
  return fs::exists(fs::path("/sys/class/tty") / port.filename() / "device", error);
}

}  // namespace

std::vector<std::string> serial_ports() {
  std::vector<std::string> ports;
  std::set<fs::path> seen;
  std::error_code error;
  for (const fs::path& entry : listing("/dev/serial/by-id")) {
    ports.push_back(entry.string());
    seen.insert(fs::canonical(entry, error));
  }
  const std::vector<fs::path> devices = listing("/dev");
  for (const std::string_view prefix : kPrefixes) {
    for (const fs::path& device : devices) {
      const std::string name = device.filename().string();
      if (name.compare(0, prefix.size(), prefix) == 0 && seen.count(device) == 0 && has_hardware(device)) {
        ports.push_back(device.string());
      }
    }
  }
  return ports;
}

std::string holders_note(const std::string& port) {
  std::error_code error;
  const fs::path device = fs::canonical(port, error);
  std::string note;
  if (error) {
    return note;
  }
  for (const fs::path& process : listing("/proc")) {
    const std::string number = process.filename().string();
    if (number.find_first_not_of("0123456789") != std::string::npos) {
      continue;
    }
    const bool is_own = std::stoi(number) == getpid();
    const std::vector<fs::path> files = is_own ? std::vector<fs::path>{} : listing(process / "fd");
    const bool holds = std::any_of(files.begin(), files.end(), [&](const fs::path& file) {
      std::error_code gone;
      return fs::read_symlink(file, gone) == device;
    });
    if (holds && parent_of(process) != getpid()) {  // the backup process of this program holds the port, too
      std::string name;
      std::ifstream(process / "comm") >> name;
      note += (note.empty() ? " (also open in " : ", ") + name + ", process " + number;
    }
  }
  return note.empty() ? "" : note + "; if it reads, it takes bytes away)";
}

std::string missing_port_remedy(const std::string& port) {
  constexpr std::string_view kSimulated = "sim:";
  return port.starts_with(kSimulated)
             ? "start m100-lab autopilot --sim " + port.substr(kSimulated.size()) + " first; it serves one command"
             : "plug the adapter in; dmesg shows under which name it appears";
}

}  // namespace m100::companion
