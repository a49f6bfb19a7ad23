// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/scenario/program/program_fixture.h"

namespace m100::scenario {

/// Both programs in simulated time.
struct WorldTest : ProgramTest {
  const fs::path world = folder / "world";
  const fs::path said = folder / "said.txt";

  /// Flies once. @param plant text of a plant file. @returns the exit code of `m100 fly`; its output, errors, result
  /// and log are in their files.
  int fly_in_world(const std::string& plant, const std::vector<std::string>& of_flight,
                   const std::vector<std::string>& of_autopilot = {}) {
    std::ofstream(folder / "plant.toml", std::ios::trunc) << "# Differences from the measured plant.\n" << plant;
    std::vector<std::string> words{
        "autopilot", "--sim", world.string(), "--events", events.string(), "--plant", (folder / "plant.toml").string()};
    words.insert(words.end(), of_autopilot.begin(), of_autopilot.end());
    Process autopilot(M100_LAB_PROGRAM, words);
    EXPECT_TRUE(wait_until([&] { return fs::exists(world); }));
    const std::string line_of_world = "sim:" + world.string();
    std::string line = started(M100_PROGRAM) + " fly --port " + line_of_world + " --pose-port " + line_of_world +
                       ".pose --vehicle " + vehicle.string() + " --gains " + table.string() + " --flight " +
                       flight_file.string() + " --log " + log.string() + " --json " + result.string() +
                       " --once --take-control";
    for (const std::string& word : of_flight) {
      line += " " + word;
    }
    const int code = Process("/bin/sh", {"-c", line + " > " + said.string()}, errors).wait();
    autopilot.interrupt();
    EXPECT_EQ(autopilot.wait(), 0);
    return code;
  }
};

}  // namespace m100::scenario
