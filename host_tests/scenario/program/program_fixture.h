// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "firmware/companion/files/text/json.h"
#include "host_tests/own_folder.h"
#include "host_tests/scenario/program/process.h"
#include "host_tests/scenario/program/real_time.h"

namespace m100::scenario {

namespace fs = std::filesystem;
using host_tests::text_of;

/// `m100` and `m100-lab autopilot` with a pose port, in their own folder, with the default vehicle.
struct ProgramTest : host_tests::FolderTest {
  const fs::path port = folder / "port";
  const fs::path pose = folder / "pose";
  const fs::path events = folder / "events.json";
  const fs::path errors = folder / "errors.txt";
  const fs::path result = folder / "result.json";
  const fs::path log = folder / "flight.ulg";
  const fs::path vehicle = folder / "vehicle.toml";
  const fs::path table = folder / "table.bin";
  const fs::path flight_file = folder / "flight.toml";

  void SetUp() override {
    FolderTest::SetUp();
    fs::copy_file(M100_VEHICLE_FILE, vehicle);
    fs::copy_file(M100_TABLE_FILE, table);
    fs::copy_file(M100_FLIGHT_FILE, flight_file);
  }

  std::unique_ptr<Process> start_autopilot(const Words& more = {}) {
    const Words words{"autopilot", "--pty",         port.string(), "--pose-pty", pose.string(),
                      "--events",  events.string(), "--duration",  "60"};
    auto process = std::make_unique<Process>(M100_LAB_PROGRAM, with(words, more));
    EXPECT_TRUE(wait_until([&] { return fs::exists(port) && fs::exists(pose); }));
    return process;
  }
  /// Repeats the flight while the machine stalls, each time in an empty folder: see real_time.h.
  void in_real_time(const std::function<void()>& flight_of_test) {
    judge_in_real_time(
        [this] {
          TearDown();
          SetUp();
        },
        flight_of_test);
  }
  /// Writes a key into a file that only its owner can read.
  fs::path key_file(const std::string& hex) const {
    fs::path path = made("key", hex + "\n");
    fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write);
    return path;
  }
  /// The files of the vehicle, in the words of every flight.
  Words models() const {
    return {"--vehicle", vehicle.string(), "--gains", table.string(), "--flight", flight_file.string()};
  }
  /// Arguments of m100 fly on the autopilot's line and the pose port of `room`, with the key.
  template <typename Room>
  Words fly_words(const Room& room, const std::string& key) const {
    return with({"fly", "--port", room.port(), "--pose-port", room.pose_port(), "--mavlink-key", key, "--json",
                 result.string()},
                models());
  }
  /// Arguments of a flight that takes control as soon as everything is ready.
  Words flight(const Words& more = {}) const {
    const Words words{"fly", "--port", port.string(), "--pose-port", pose.string(), "--take-control"};
    return with(with(words, models()), more);
  }
  /// The program with these words, for a shell.
  static std::string line_of(const Words& arguments) {
    std::string line = started(M100_PROGRAM);
    for (const std::string& argument : arguments) {
      line += " " + argument;
    }
    return line;
  }
  /// Runs the program to its end. @returns its exit code; stderr is in error().
  int run(const Words& arguments) { return Process(M100_PROGRAM, arguments, errors).wait(); }
  int run_lab(const Words& arguments) { return Process(M100_LAB_PROGRAM, arguments, errors).wait(); }
  /// What the program reported with --json.
  Json reported() const { return Json::parse(text_of(result)); }
  std::string error() const { return text_of(errors); }
  /// Ends the autopilot. @returns its summary.
  Json examined(Process& autopilot) const {
    autopilot.interrupt();
    EXPECT_EQ(autopilot.wait(), 0);
    return summary();
  }
  /// The autopilot's events in their order.
  std::vector<Json> every_event() const {
    std::vector<Json> all;
    std::ifstream file(events);
    for (std::string line; std::getline(file, line);) {
      all.push_back(Json::parse(line));
    }
    return all;
  }
  /// The last of the autopilot's events.
  Json summary() const { return every_event().back(); }
  /// Number of occurrences of this text in the autopilot's events.
  std::size_t noted(const std::string& what) const {
    const std::string all = text_of(events);
    std::size_t count = 0;
    for (std::size_t at = all.find(what); at != std::string::npos; at = all.find(what, at + 1)) {
      ++count;
    }
    return count;
  }
  /// Waits until the text occurs more often than that in the events. @returns false if it never did.
  bool wait_for(const std::string& what, std::size_t more_than = 0) const {
    return wait_until([&] { return noted(what) > more_than; });
  }
  bool wait_for_control() const { return wait_for("\"obtained\""); }
};

}  // namespace m100::scenario
