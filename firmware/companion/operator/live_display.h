// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <netinet/in.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "firmware/app/tick_record.h"
#include "firmware/core/spsc_ring.h"

namespace m100::companion {

class Subcommand;

/// What the operator wants to see during the flight.
struct LiveOptions {
  std::string to;               ///< "HOST:PORT" that receives the JSON; empty: none
  std::string status = "auto";  ///< auto: if the standard output is a terminal; always, never
};

void add_live_options(const Subcommand& app, LiveOptions& options);

/// Parses an IPv4 address and a port; empty text: nullopt. Errors: UsageError if it is neither.
std::optional<sockaddr_in> receiver_of(const std::string& text);

/// One object of JSON, as PlotJuggler's UDP server takes it; its `timestamp` is the tick's time in seconds.
std::string json_of(const app::TickRecord<double>& record);
/// One line: failsafe state, position, distance from the course, latency and loss of the poses, link. @param
/// lost_share lost poses over sent ones.
std::string status_of(const app::TickRecord<double>& record, double lost_share);

/// What to put before a line for the terminal: it erases the status line, if this process shows one; else empty.
std::string_view line_begin();

/// Shows a flight from a thread of its own: values as JSON over UDP fifty times a second, and a line on the terminal
/// five times a second. The thread that flies hands over copies; it neither waits nor allocates. A state that finds no
/// room in the queue is not shown. The packets are unsigned and one-way.
class LiveDisplay {
 public:
  static constexpr std::uint32_t kTicksPerState = 2;
  static constexpr std::uint32_t kStatesPerLine = 10;

  /// Errors: UsageError.
  explicit LiveDisplay(const LiveOptions& options);
  ~LiveDisplay() { finish(); }
  LiveDisplay(const LiveDisplay&) = delete;
  LiveDisplay& operator=(const LiveDisplay&) = delete;

  void start();
  /// Shows the remaining states, erases the line, and ends the thread.
  void finish();

  /// Called by the thread that flies, every tick.
  void publish(const app::TickRecord<double>& record) {
    if (thread_.joinable() && ticks_++ % kTicksPerState == 0) {
      (void)records_.push(record);
    }
  }

 private:
  void show_all();
  void show(const app::TickRecord<double>& record);
  void show_line(const app::TickRecord<double>& record);

  std::optional<sockaddr_in> receiver_;
  bool has_line_;
  int descriptor_ = -1;
  core::SpscRing<app::TickRecord<double>, 64> records_;
  std::uint32_t ticks_ = 0;
  std::atomic<bool> running_{true};
  std::thread thread_;
  // Used by the thread that shows.
  std::uint32_t shown_ = 0;
  std::array<link::PoseLinkStats, 5> former_{};  ///< shown by the last five lines, of one second
  std::uint32_t lines_ = 0;
};

}  // namespace m100::companion
