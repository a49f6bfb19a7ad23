// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/log/flight_log.h"

#include <algorithm>
#include <array>

namespace m100::log {
namespace {

constexpr std::uint16_t kTickId = 0;
constexpr std::uint16_t kBytesId = 1;
constexpr std::uint16_t kExcitationId = 2;
constexpr std::uint16_t kVibrationId = 3;
constexpr std::array kFormats{kTickFormat, kBytesFormat, kExcitationFormat, kVibrationFormat};

}  // namespace

core::Status FlightLogWriter::begin(core::TimePoint now, std::span<const Note> notes) {
  return writer_.begin(now, kFormats, notes);
}

void FlightLogWriter::append(const TickRecord& record) {
  writer_.append(kTickId, std::as_bytes(std::span(&record, 1)));
}

void FlightLogWriter::append(const ExcitationRecord& record) {
  writer_.append(kExcitationId, std::as_bytes(std::span(&record, 1)));
}

void FlightLogWriter::append(const VibrationRecord& record) {
  writer_.append(kVibrationId, std::as_bytes(std::span(&record, 1)));
}

void FlightLogWriter::append(Stream stream, core::TimePoint now, std::span<const std::byte> bytes) {
  append_bytes(writer_, kBytesId, stream, now, bytes);
}

void append_bytes(UlogWriter& writer, std::uint16_t id, Stream stream, core::TimePoint now,
                  std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    BytesRecord record;
    record.timestamp = static_cast<std::uint64_t>(now.time_since_epoch().count());
    record.stream = static_cast<std::uint8_t>(stream);
    record.count = static_cast<std::uint8_t>(std::min(bytes.size(), record.bytes.size()));
    for (std::size_t i = 0; i < record.count; ++i) {
      record.bytes[i] = std::to_integer<std::uint8_t>(bytes[i]);
    }
    writer.append(id, std::as_bytes(std::span(&record, 1)));
    bytes = bytes.subspan(record.count);
  }
}

}  // namespace m100::log
