// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "firmware/app/serial_link.h"
#include "hal/linux/monotonic_clock.h"
#include "hal/linux/serial_port.h"

namespace m100::app {

struct FlyOptions {
  std::string port;
  std::uint32_t baud = 230400;
  std::uint32_t app_id = 0;
  std::string key_file;
  std::string channel = "virtual_rc";
  double rate_hz = 0.0;
  bool paper_100_hz = false;
  bool dry_run = false;
  bool take_control = false;
  double hold_s = 5.0;
  double patience_s = 30.0;
  std::string json;
  // Not in a dry run.
  std::string pose_port;
  std::uint32_t pose_baud = 115200;
  std::string vehicle;
  std::string gains;
  std::string course;
  std::string log;
};

/// Set by SIGINT, SIGTERM and SIGHUP: give control back and end.
bool stop_asked();
void watch_signals();
/// The operator pressed Enter since the call before.
bool key_pressed();

/// Opens a port or throws UsageError with the reason.
void open_or_explain(hal::SerialPort& port);

/// A line for the operator, if the terminal takes it now: one that is stopped (Ctrl-S) must not stop the flight.
void say(const std::string& line);

/// One line about where the authority table stands, with the remedy where there is one.
std::string describe(const AuthorityView& authority);

/// Ticks of 10 ms by absolute deadlines; after a stall of more than one tick the grid starts anew.
class TickClock {
 public:
  core::TimePoint now() { return clock_.now(); }
  /// Waits for the next tick. @returns its time.
  core::TimePoint next();
  /// Ticks that came more than two periods after the one before (R9).
  std::uint32_t stalls() const { return stalls_; }
  /// The longest time between two ticks.
  core::Duration longest() const { return longest_; }

 private:
  hal::MonotonicClock clock_;
  core::TimePoint deadline_{};
  core::TimePoint last_{};
  std::uint32_t stalls_ = 0;
  core::Duration longest_{0};
};

// What `m100 fly` does. @returns true: control was taken, held and given back.

/// Start-up, control, neutral commands, release; nobody looks at a pose.
bool dry_run(const FlyOptions& options, const LinkConfig& config, hal::SerialPort& port);
/// The flight controller on a course, by the pose that comes over the second port.
bool fly_course(const FlyOptions& options, const LinkConfig& config, hal::SerialPort& port);

}  // namespace m100::app
