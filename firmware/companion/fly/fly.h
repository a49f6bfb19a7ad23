// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "firmware/companion/fly/pose_port.h"
#include "firmware/companion/operator/live_display.h"
#include "firmware/companion/operator/operator_input.h"
#include "firmware/link/serial_link.h"
#include "hal/linux/serial_port.h"
#include "protocol/aes256.h"

namespace m100::companion {

class Subcommand;

/// The options of `fly`; `handshake`, `record` and `check` have some of them.
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
  bool release_only = false;  ///< of the handshake only
  bool take_off = false;
  bool land = false;
  double hold_s = 5.0;
  double patience_s = 30.0;
  std::string json;
  // Not used by the handshake.
  PoseOptions pose;
  std::string vehicle;
  std::string gains;
  std::string flight;
  std::string mode;  ///< empty: that of the flight file
  std::string law = "mpc";
  std::vector<std::string> disabled_checks;  ///< from names_for_override()
  std::string course;
  std::string excite;
  std::string log;
  LiveOptions live;
};

/// Refuses files that cannot be used, see FileUse. Errors: FileUseError.
void check_files(const FlyOptions& options);

/// Adds the options of the link to a subcommand.
void add_link_options(const Subcommand& app, FlyOptions& options);

/// The configuration of the link by the options, with its key. Errors: UsageError, FileUseError.
struct PreparedLink {
  explicit PreparedLink(const FlyOptions& options);
  PreparedLink(const PreparedLink&) = delete;
  PreparedLink& operator=(const PreparedLink&) = delete;

  std::optional<protocol::Aes256> cipher;
  link::LinkConfig config;
};

/// The number of SIGINT, SIGTERM, SIGHUP, SIGQUIT and SIGTSTP received: each means give control back and end.
std::uint32_t stops();
inline bool stop_requested() { return stops() != 0; }
void watch_signals();
/// The operator's commands since the last call. The end of the standard input is not a command.
OperatorInput read_operator_input();
/// Discards what was typed before there was anything to answer. Input in a pipe is kept.
void discard_operator_input();

/// Opens a port or throws UsageError with the reason.
void open_or_explain(hal::SerialPort& port);

/// Prints a line for the operator, by the LineWriter if there is one.
void print_line(std::string_view line);

/// Ticks of 10 ms by absolute deadlines; a tick that ends more than a period after its deadline starts the grid anew.
class TickClock {
 public:
  /// @param port whose clock is used: a simulated port has its own, any other uses the machine's.
  /// @param before_time called just before the time of a tick is taken: marks the bytes that have arrived
  explicit TickClock(
      const std::string& port, std::function<void()> before_time = [] {})
      : clock_(port), before_time_(std::move(before_time)) {}
  core::TimePoint now() {
    before_time_();
    return clock_.now();
  }
  /// Waits for the next tick. @returns its time.
  core::TimePoint next();
  /// Ticks that came more than two periods after the one before (R9).
  std::uint32_t stalls() const { return stalls_; }
  /// The longest time between two ticks.
  core::Duration longest() const { return longest_; }

 private:
  hal::PortClock clock_;
  std::function<void()> before_time_;
  core::TimePoint deadline_{};
  core::TimePoint last_{};
  std::uint32_t stalls_ = 0;
  core::Duration longest_{0};
};

}  // namespace m100::companion
