// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fstream>

#include "host_tests/golden/flight/flight_recording.h"

// Records a recording: the flight program flies the simulated aircraft, and everything that it receives is also written
// to a file.
namespace m100::golden {

/// Reads what has arrived, as far as it fits. @returns the number of bytes.
inline std::uint16_t take(hal::Uart& from, std::span<std::byte> into) {
  std::size_t filled = 0;
  for (std::size_t count = 1; count > 0 && filled < into.size(); filled += count) {
    count = from.read(into.subspan(filled)).value_or(0);
  }
  return static_cast<std::uint16_t>(filled);
}

/// A UART that gives the program the recorded bytes and passes on what the program sends.
class RecordingUart final : public ReplayedUart {
 public:
  RecordingUart(hal::Uart& line) : line_(line) {}
  core::Expected<std::size_t> write(std::span<const std::byte> source) override { return line_.write(source); }

 private:
  hal::Uart& line_;
};

/// Appends one tick to the recording.
inline void write(std::ofstream& file, const RecordedTick& tick) {
  const auto put = [&file](std::span<const std::byte> bytes) {
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  };
  put(std::as_bytes(std::span(&tick.head, 1)));
  put(tick.from_autopilot());
  put(tick.from_pose());
}

}  // namespace m100::golden
