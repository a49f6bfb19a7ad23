// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstring>
#include <vector>

#include "firmware/companion/files/recorded_flight.h"
#include "firmware/log/flight_log.h"

namespace m100::companion {

/// Reads the records that a replayed flight has logged in a tick: the last messages in the ring of its log, after
/// bytes.
class RecordWindow {
 public:
  RecordWindow() : ring_(storage_), log_(ring_) {}
  log::FlightLogWriter& log() { return log_; }
  /// @param excited a record of the excitation precedes the tick's.
  RecordedFlight::Tick take(bool excited) {
    std::vector<std::byte> bytes;
    while (!ring_.front().empty()) {
      bytes.insert(bytes.end(), ring_.front().begin(), ring_.front().end());
      ring_.pop(ring_.front().size());
    }
    RecordedFlight::Tick tick;
    const std::byte* at = bytes.data() + bytes.size() - sizeof tick.record;
    std::memcpy(&tick.record, at, sizeof tick.record);
    if (excited) {
      at -= kMessageHead + sizeof(log::ExcitationRecord);
      std::memcpy(&tick.excitation.emplace(), at, sizeof(log::ExcitationRecord));
    }
    return tick;
  }

 private:
  static constexpr std::size_t kMessageHead = 5;  ///< size, type and number of a data message
  /// As large as the ring of a flight's log: the tick after the wait for a first pose reads the bytes of up to 5 s.
  std::vector<std::byte> storage_ = std::vector<std::byte>(1U << 20U);
  log::Ring ring_;
  log::FlightLogWriter log_;
};

}  // namespace m100::companion
