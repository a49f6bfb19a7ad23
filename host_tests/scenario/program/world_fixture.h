// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/scenario/program/program_fixture.h"

namespace m100::scenario {

/// Both programs in simulated time.
struct WorldTest : ProgramTest {
  const std::string world = "sim:" + path("world");
  const fs::path said = folder / "said.txt";

  std::unique_ptr<Process> start_world(const Words& more) {
    auto autopilot = std::make_unique<Process>(
        M100_LAB_PROGRAM, with({"autopilot", "--sim", path("world"), "--events", events.string()}, more));
    EXPECT_TRUE(wait_until([&] { return fs::exists(folder / "world"); }));
    return autopilot;
  }
  /// Words for an autopilot that follows this script; none if it is empty.
  Words scripted(const std::string& script) const {
    return script.empty() ? Words{} : Words{"--script", made("script.txt", script)};
  }
  /// A flight in that world, for a shell; its output, errors, result and log are in their files.
  std::string command(const Words& options) const {
    const Words words{"fly",        "--port", world,           "--pose-port", world + ".pose", "--log",
                      log.string(), "--json", result.string(), "--once",      "--take-control"};
    return line_of(with(with(words, models()), options)) + " > " + said.string() + " 2> " + errors.string();
  }
  /// Flies once. @param plant text of a plant file. @returns the exit code of `m100 fly`.
  int fly_in_world(const std::string& plant, const Words& of_flight, const Words& of_autopilot = {}) {
    fs::remove(log);
    const Words air{"--plant", made("plant.toml", "# Differences from the measured plant.\n" + plant)};
    const auto autopilot = start_world(with(air, of_autopilot));
    const int code = Process("/bin/sh", {"-c", command(of_flight)}).wait();
    (void)examined(*autopilot);
    return code;
  }
  std::string all_said() const { return text_of(said) + error(); }
};

}  // namespace m100::scenario
