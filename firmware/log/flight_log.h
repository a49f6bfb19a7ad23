// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/core/status.h"
#include "firmware/core/time.h"
#include "firmware/log/records.h"
#include "firmware/log/ulog_writer.h"

namespace m100::log {

/// The log of a flight: a record of every tick, records of an excitation and of vibration, every byte of both lines,
/// and lines of text.
class FlightLogWriter {
 public:
  explicit FlightLogWriter(Ring& ring) : writer_(ring) {}

  /// As UlogWriter::begin(), with the formats of our records.
  core::Status begin(core::TimePoint now, std::span<const Note> notes);

  void append(const TickRecord& record);
  void append(const ExcitationRecord& record);
  void append(const VibrationRecord& record);
  void append(Stream stream, core::TimePoint now, std::span<const std::byte> bytes);
  void append(core::TimePoint now, std::string_view text) { writer_.append(now, text); }

  std::uint32_t dropped() const { return writer_.dropped(); }

 private:
  UlogWriter writer_;
};

/// Raw bytes as the required number of BytesRecords with this id.
void append_bytes(UlogWriter& writer, std::uint16_t id, Stream stream, core::TimePoint now,
                  std::span<const std::byte> bytes);

}  // namespace m100::log
