// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstdint>
#include <fstream>
#include <mutex>
#include <string>
#include <thread>

#include "firmware/companion/files/text/json.h"
#include "host_tests/sim/autopilot/n1_autopilot.h"

namespace m100::lab::autopilot {

/// Writes JSON lines: the events that the autopilot received and caused, and ten times a second the true position,
/// velocity, roll and pitch of the aircraft. The last line is a summary: the autopilot's counters, and who has control.
class EventFile {
 public:
  /// Who waits for the disk.
  enum class WriteMode : std::uint8_t {
    kAtOnce,     ///< the caller: in simulated time every line is in the file before time goes on
    kInAThread,  ///< a thread: in real time a stalled disk must not stop telemetry and poses. If the program is
                 ///< killed, the lines that the thread has not yet written are lost.
  };
  /// @throws InputError: the file cannot be written.
  EventFile(const std::string& path, WriteMode writes);

  void write(const sim::N1Event& event);
  /// Writes the true state if the next tenth of a second has begun; other calls write nothing.
  void write_truth(core::TimePoint now, const sim::VehicleState& state);
  /// Writes the last line and waits until every line is written; nothing may be written after this call.
  /// @param longest_lag longest time between two steps of the autopilot: time stamps are late by up to that.
  /// @throws InputError if this line or an earlier one could not be written.
  void summarise(core::TimePoint now, const sim::N1Autopilot& autopilot, core::Duration longest_lag);

 private:
  void write_line(const Json& line);
  void write_waiting(const std::stop_token& stop);
  void expect_written() const;

  std::string path_;
  std::ofstream file_;  ///< the thread's while there is one
  core::TimePoint next_truth_{};
  std::mutex mutex_;
  std::condition_variable_any lines_came_;
  std::string waiting_;  ///< guarded by mutex_: lines for the thread
  std::jthread writer_;  ///< the last member: it ends before what it uses
};

}  // namespace m100::lab::autopilot
