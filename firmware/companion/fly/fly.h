// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/companion/fly/live.h"
#include "firmware/companion/fly/pose_port.h"
#include "firmware/companion/fly/said.h"
#include "firmware/link/serial_link.h"
#include "hal/linux/serial_port.h"
#include "protocol/aes256.h"

namespace CLI {
class App;
}  // namespace CLI

namespace m100::companion {

/// The options of `fly`; those of the link are `handshake`'s too.
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
  bool once = false;
  bool take_off = false;
  bool land = false;
  double hold_s = 5.0;
  double patience_s = 30.0;
  std::string json;
  // Not of the handshake.
  PoseOptions pose;
  std::string vehicle;
  std::string gains;
  std::string flight;
  std::string mode;  ///< empty: the flight file's
  std::string law = "mpc";
  std::vector<std::string> checks_off;  ///< names_for_override
  std::string course;
  std::string excite;
  std::string log;
  LiveOptions live;
};

/// The options of the link, for a subcommand that has one.
void add_link_options(CLI::App& app, FlyOptions& options);

/// The link as the options have it, with its key. Errors: UsageError.
struct PreparedLink {
  explicit PreparedLink(const FlyOptions& options);
  PreparedLink(const PreparedLink&) = delete;
  PreparedLink& operator=(const PreparedLink&) = delete;

  std::optional<protocol::Aes256> cipher;
  link::LinkConfig config;
};

/// How often SIGINT, SIGTERM, SIGHUP or SIGQUIT came: give control back and end.
std::uint32_t stops();
inline bool stop_asked() { return stops() != 0; }
void watch_signals();
/// What the operator has said since the call before. The end of the standard input is no word.
Said heard_from_operator();
/// Words that were typed before there was anything to answer are none. What stands in a pipe is kept.
void forget_words();

/// Opens a port or throws UsageError with the reason.
void open_or_explain(hal::SerialPort& port);

/// A line for the operator, if the terminal takes it now: one that is stopped (Ctrl-S) must not stop the flight.
/// A status line that stands there is taken away first.
void say(std::string_view line);

/// One line about where the authority table stands, with the remedy where there is one.
std::string describe(const link::AuthorityView& authority);

/// Ticks of 10 ms by absolute deadlines; after a stall of more than one tick the grid starts anew.
class TickClock {
 public:
  /// @param port whose time it is: a simulated one brings its own, any other lives in the machine's.
  explicit TickClock(const std::string& port) : clock_(port) {}
  core::TimePoint now() { return clock_.now(); }
  /// Waits for the next tick. @returns its time.
  core::TimePoint next();
  /// Ticks that came more than two periods after the one before (R9).
  std::uint32_t stalls() const { return stalls_; }
  /// The longest time between two ticks.
  core::Duration longest() const { return longest_; }

 private:
  hal::PortClock clock_;
  core::TimePoint deadline_{};
  core::TimePoint last_{};
  std::uint32_t stalls_ = 0;
  core::Duration longest_{0};
};

// What `m100 fly` does.

/// Everything of a flight that can be done without sending. @returns true: telemetry came, and the pose is fresh where
/// one was asked for.
bool dry_run(const FlyOptions& options, const link::LinkConfig& link, hal::Uart& autopilot);
/// @returns true: control was taken, held and given back. The flight controller on a course, by the pose that comes
/// over the second port.
bool fly_course(const FlyOptions& options, const link::LinkConfig& config, hal::SerialPort& port);

}  // namespace m100::companion
