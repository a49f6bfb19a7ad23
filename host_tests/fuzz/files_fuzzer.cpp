// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry point for our own kinds of files: vehicle, plant, flight file, course, excitation, script, gain
// table, key, memory of signatures, recorded flight, quadratic programs, frames as JSON. It is one program; the first
// byte of an input chooses the reader. What a reader accepts is then used as the programs use it.
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "firmware/companion/files/course/course.h"
#include "firmware/companion/files/course/course_validation.h"
#include "firmware/companion/files/excitation_file.h"
#include "firmware/companion/files/flight_file.h"
#include "firmware/companion/files/flight_limits.h"
#include "firmware/companion/files/recorded_flight.h"
#include "firmware/companion/files/signature_times_file.h"
#include "firmware/companion/files/text/key_file.h"
#include "firmware/companion/files/vehicle_file.h"
#include "firmware/core/sha256.h"
#include "firmware/mpc/table_file.h"
#include "host_tests/lab/frames/frame_text.h"
#include "host_tests/lab/gains/instances.h"
#include "host_tests/sim/autopilot/n1_script.h"
#include "host_tests/sim/world/base_plant.h"
#include "host_tests/sim/world/plant_file.h"

namespace {

using namespace m100;

constexpr const char* kName = "file";  // every refusal must begin with this name

/// A file in memory, rewritten for every input and readable by its owner only.
const std::string& as_file(std::string_view bytes) {
  static const int file = memfd_create("file", 0);
  static const std::string path = "/proc/self/fd/" + std::to_string(file);
  const bool written = fchmod(file, S_IRUSR | S_IWUSR) == 0 && ftruncate(file, 0) == 0 &&
                       pwrite(file, bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size());
  if (!written) {
    std::abort();
  }
  return path;
}

void vehicle(std::string_view bytes) {
  const companion::VehicleFile file = companion::parse_vehicle(bytes, kName);
  // Writing the vehicle and reading it back must give the same numbers, so the second text has the digest of the first.
  const std::string text = companion::to_text(file.vehicle, file.sources);
  const companion::VehicleFile again = companion::parse_vehicle(text, kName);
  if (companion::to_text(again.vehicle, again.sources) != text) {
    std::abort();
  }
  static_cast<void>(sim::plant_of(file.vehicle));
}

void plant(std::string_view bytes) { static_cast<void>(sim::parse_plant(bytes, kName)); }

void flight(std::string_view bytes) {
  const companion::FlightFile file = companion::parse_flight(bytes, kName);
  static_cast<void>(companion::fence_of(file, {}));
  static_cast<void>(companion::limits_of(file));
  static_cast<void>(companion::goal_limits_of(file));
}

void course(std::string_view bytes) {
  static const auto laid = std::make_unique<ref::Trajectory<double>>();
  const auto pieces = companion::parse_course(bytes, ref::Waypoint<double>{}, *laid, kName);
  companion::validate_course(*laid, pieces, {}, companion::CourseLimits{}, kName);
}

void excitation(std::string_view bytes) {
  const companion::ExcitationFile file = companion::parse_excitation(bytes, kName);
  static_cast<void>(file.plan());
  static_cast<void>(companion::note_of(file, kName));
}

void script(std::string_view bytes) { static_cast<void>(sim::read_n1_script(std::string(bytes))); }

/// Repairs the checksum over the whole file; otherwise nothing after the checksum test would ever be tried.
void table(std::string_view bytes) {
  static const auto storage = std::make_unique<mpc::TableStorage<double>>();
  std::string whole(bytes);
  core::Sha256Digest digest{};
  if (whole.size() >= digest.size()) {
    const std::size_t end = whole.size() - digest.size();
    digest = core::sha256(std::as_bytes(std::span(whole).first(end)));
    std::copy(digest.begin(), digest.end(), reinterpret_cast<std::uint8_t*>(whole.data() + end));
  }
  core::Sha256Digest of_vehicle{};
  constexpr std::size_t kVehicleAt = 16;
  if (whole.size() >= kVehicleAt + of_vehicle.size()) {
    std::copy_n(reinterpret_cast<const std::uint8_t*>(whole.data()) + kVehicleAt, of_vehicle.size(),
                of_vehicle.begin());
  }
  static_cast<void>(storage->load(std::as_bytes(std::span(whole)), of_vehicle));
}

void key(std::string_view bytes) { static_cast<void>(companion::read_key(as_file(bytes))); }

void memory(std::string_view bytes) {
  const mavlink::ReplayMemory memory = companion::parse_replay_memory(std::string(bytes), kName);
  static_cast<void>(companion::parse_replay_memory(companion::text_of(memory, 0), kName));
}

void recorded(std::string_view bytes) { static_cast<void>(companion::read_flight(as_file(bytes))); }

void programs(std::string_view bytes) {
  std::istringstream lines{std::string(bytes)};
  static_cast<void>(lab::gains::read_instances(lines, kName));
}

void frame(std::string_view bytes) {
  const Json line = Json::parse(bytes);
  if (line.is_object()) {
    static_cast<void>(lab::frame_from_line(line, {kName, 1}, std::nullopt));
  }
}

constexpr std::array kReaders{&vehicle, &plant, &flight, &course,   &excitation, &script,
                              &table,   &key,   &memory, &recorded, &programs,   &frame};

/// Every refusal begins with the file's name; only for scripts does the caller put the name in front.
void expect_named(const std::string& what, bool by_caller) {
  if (what.empty() || !(by_caller || what.starts_with(kName) || what.starts_with("/proc/"))) {
    std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) {
    return 0;
  }
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  try {
    kReaders[data[0] % kReaders.size()](bytes);
  } catch (const sim::N1ScriptError& refusal) {
    expect_named(refusal.what(), true);
  } catch (const std::runtime_error& refusal) {  // the base class of all refusals; any other exception is a finding
    expect_named(refusal.what(), false);
  }
  return 0;
}
