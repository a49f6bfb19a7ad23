// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "firmware/log/records.h"

namespace m100::companion {

/// Why a log cannot be read or replayed, in one line.
class FlightLogError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A flight log as written by log::FlightLogWriter, read back. Linux only.
struct RecordedFlight {
  struct Tick {
    log::TickRecord record;
    std::vector<std::byte> autopilot_in;
    std::vector<std::byte> autopilot_out;
    std::vector<std::byte> pose_in;
    std::vector<std::byte> pose_out;  ///< time-synchronisation requests to the sender
    std::optional<log::ExcitationRecord> excitation;
  };
  std::map<std::string, std::string> notes;
  std::vector<Tick> ticks;
  bool flew_mission = false;  ///< of MAVLink, which former versions flew
};

/// Reads the whole file. Bytes belong to the tick whose record follows them. A truncated end is ignored: the power may
/// have failed. Errors: FlightLogError for a file that is damaged, of another program or of another version.
RecordedFlight read_flight(const std::string& path);
/// As read_flight(), for the bytes of a log. @param name of the log, for messages.
RecordedFlight parse_flight_log(std::string bytes, const std::string& name);

}  // namespace m100::companion
