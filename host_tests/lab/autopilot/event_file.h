// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "host_tests/sim/autopilot/n1_autopilot.h"

namespace m100::lab::autopilot {

/// JSON lines of what the autopilot received and did, and ten times a second where the aircraft really is; the last one
/// sums up what a strict examiner saw. Each line is written as it happens, so a program that is killed leaves them.
class EventFile {
 public:
  /// @throws InputError
  explicit EventFile(const std::string& path);

  void write(const sim::N1Event& event);
  /// Writes the truth where a tenth of a second has passed since the last.
  void tell_truth(core::TimePoint now, const sim::VehicleState& state);
  /// @param longest_lag the machine kept the autopilot waiting: its own stamps are late by up to that.
  /// @throws InputError where a line could not be written, this one or an earlier one.
  void summarise(core::TimePoint now, const sim::N1Autopilot& autopilot, core::Duration longest_lag);

 private:
  using Json = nlohmann::ordered_json;

  void write_line(const Json& line);
  void expect_written() const;

  std::string path_;
  std::ofstream file_;
  core::TimePoint next_truth_{};
};

}  // namespace m100::lab::autopilot
