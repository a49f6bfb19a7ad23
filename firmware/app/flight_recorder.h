// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/ctl/excitation.h"
#include "firmware/ctl/law/flight_law.h"
#include "firmware/est/estimate.h"
#include "firmware/est/measurement.h"
#include "firmware/link/byte_tap.h"
#include "firmware/link/serial_link.h"
#include "firmware/log/flight_log.h"
#include "firmware/ref/window.h"
#include "firmware/safety/supervisor.h"
#include "firmware/sysid/residual_monitor.h"
#include "firmware/vrc/sticks.h"

namespace m100::app {

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

/// What a tick hands to the log.
template <typename T>
struct FlownTick {
  core::TimePoint now;
  core::Duration elapsed;
  std::uint32_t orders;
  const est::Measurement<T>& measured;
  const est::Estimate<T>& estimate;
  const ref::Window<T>& reference;
  const ctl::Command<T>& commanded;
  const safety::SupervisedCommand<T>& supervised;
  const vrc::Sticks& sticks;
  core::Status sent;
};

/// Writes the flight log: the bytes of both lines, one record a tick and, from the start of an excitation on, one
/// excitation record a tick. T is float or double.
template <typename T>
class FlightRecorder {
 public:
  /// @param log may be null: then nothing is written.
  explicit FlightRecorder(log::FlightLogWriter* log)
      : log_(log),
        autopilot_tap_(log, log::Stream::kAutopilotIn, log::Stream::kAutopilotOut),
        pose_tap_(log, log::Stream::kPoseIn, log::Stream::kPoseOut) {}

  link::ByteTap* autopilot_tap() { return &autopilot_tap_; }
  link::ByteTap* pose_tap() { return &pose_tap_; }

  /// Once per tick, as its last step.
  void append(const FlownTick<T>& flown, const link::SerialLink& link, const safety::Supervisor<T>& supervisor,
              const ctl::FlightLaw<T>& law, const sysid::ResidualMonitor<T>& residual,
              const ctl::Excitation<T>& excitation);

 private:
  void update_newest(const est::Measurement<T>& measured);
  log::TickRecord record(const FlownTick<T>& flown) const;

  log::FlightLogWriter* log_;
  LogTap autopilot_tap_;
  LogTap pose_tap_;
  est::Measurement<T> newest_;  ///< newest pose and attitude, which the record repeats; is_new as of this tick
};

extern template class FlightRecorder<float>;
extern template class FlightRecorder<double>;

}  // namespace m100::app
