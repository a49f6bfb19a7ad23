// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/preflight/serial_ports.h"

#include <algorithm>
#include <array>
#include <filesystem>
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

}  // namespace m100::companion
