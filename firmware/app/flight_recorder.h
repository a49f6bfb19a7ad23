// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/app/tick_record.h"
#include "firmware/ctl/excitation.h"
#include "firmware/link/byte_tap.h"
#include "firmware/log/flight_log.h"

namespace m100::app {

/// The tick as the log holds it. @param dropped_messages of the log so far
template <typename T>
log::TickRecord logged(const TickRecord<T>& record, std::uint32_t dropped_messages);
/// The excitation as the log holds it; nullopt: it has not begun.
template <typename T>
std::optional<log::ExcitationRecord> logged(const ctl::Excitation<T>& excitation, core::TimePoint now);

/// Writes the bytes that pass a link into the flight log.
class LogTap final : public link::ByteTap {
 public:
  LogTap(log::FlightLogWriter* log, log::Stream in, log::Stream out) : log_(log), in_(in), out_(out) {}
  void received(std::span<const std::byte> bytes, core::TimePoint now) override { append(in_, bytes, now); }
  void sent(std::span<const std::byte> bytes, core::TimePoint now) override { append(out_, bytes, now); }

 private:
  void append(log::Stream stream, std::span<const std::byte> bytes, core::TimePoint now) {
    if (log_ != nullptr) {
      log_->append(stream, now, bytes);
    }
  }
  log::FlightLogWriter* log_;
  log::Stream in_;
  log::Stream out_;
};

/// Writes the flight log: the bytes of both lines, one record a tick and, from the start of an excitation on, one
/// excitation record a tick.
class FlightRecorder {
 public:
  /// @param log may be null: then nothing is written.
  explicit FlightRecorder(log::FlightLogWriter* log)
      : log_(log),
        autopilot_tap_(log, log::Stream::kAutopilotIn, log::Stream::kAutopilotOut),
        pose_tap_(log, log::Stream::kPoseIn, log::Stream::kPoseOut) {}

  link::ByteTap* autopilot_tap() { return &autopilot_tap_; }
  link::ByteTap* pose_tap() { return &pose_tap_; }

  bool writes() const { return log_ != nullptr; }
  /// Once per tick, as its last step, if it writes. T is float or double.
  template <typename T>
  void append(const TickRecord<T>& record) {
    if (record.excitation) {
      log_->append(*record.excitation);
    }
    log_->append(logged(record, log_->dropped()));
  }

 private:
  log::FlightLogWriter* log_;
  LogTap autopilot_tap_;
  LogTap pose_tap_;
};

}  // namespace m100::app
