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

#include "firmware/app/flight_controller.h"
#include "firmware/core/spsc_ring.h"

namespace CLI {
class App;
}  // namespace CLI

namespace m100::companion {

/// What the operator wants to see while it flies.
struct LiveOptions {
  std::string to;               ///< "HOST:PORT"; empty: nobody
  std::string status = "auto";  ///< auto: where the standard output is a terminal; always, never
};

void add_live_options(CLI::App& app, LiveOptions& options);

/// An IPv4 address and a port. Errors: UsageError, where it is none; empty text: nothing.
std::optional<sockaddr_in> receiver_of(const std::string& text);

/// What is shown of a tick: a copy, so that whoever shows it needs nothing of the flight. World frame, SI units.
struct LiveState {
  double t_s = 0.0;
  safety::Rung rung = safety::Rung::kSilent;
  bool in_control = false;
  bool healthy = false;
  std::array<double, 3> position_m{};
  std::array<double, 3> velocity_m_s{};
  std::array<double, 3> reference_m{};
  std::array<double, 2> tilt_rad{};
  double yaw_rad = 0.0;
  ctl::Command<double> command{};  ///< that the ladder lets through; roll and pitch of the body, forward-left-up
  double pose_age_s = 0.0;         ///< of the newest, since its capture
  double pose_latency_s = 0.0;     ///< that every pose has
  double pose_jitter_s = 0.0;      ///< on top of it: 99th percentile
  std::uint64_t poses = 0;         ///< taken, since the beginning
  std::uint64_t poses_lost = 0;
  double telemetry_hz = 0.0;
  double telemetry_age_s = 0.0;  ///< not a number: none has come
  std::uint8_t battery_percent = 0;
};

LiveState live_state(const app::FlightController<double>& controller, const ref::Trajectory<double>& trajectory,
                     core::TimePoint now);
/// One object of JSON, as PlotJuggler's UDP server takes it; `timestamp` is the time of the tick.
std::string json_of(const LiveState& state);
/// Rung, position, distance from the reference, latency and loss of the poses, link. @param lost_share of the poses.
std::string status_of(const LiveState& state, double lost_share);

/// What a line for the terminal must begin with: it takes a status line away, if one is shown in this process.
std::string_view line_begin();

/// Shows a flight while it flies, from a thread of its own: values as JSON over UDP fifty times a second, and a line on
/// the terminal five times a second. The thread that flies hands over copies; it neither waits nor allocates. What
/// finds no room is not shown. Nothing is signed: it is for reading, and nobody answers.
class Live {
 public:
  static constexpr std::uint32_t kTicksPerState = 2;
  static constexpr std::uint32_t kStatesPerLine = 10;

  /// Errors: UsageError.
  explicit Live(const LiveOptions& options);
  ~Live() { finish(); }
  Live(const Live&) = delete;
  Live& operator=(const Live&) = delete;

  void start();
  /// Shows what is left, takes the line away, and ends.
  void finish();

  /// From the thread that flies, every tick.
  void tell(const app::FlightController<double>& controller, const ref::Trajectory<double>& trajectory,
            core::TimePoint now) {
    if (thread_.joinable() && ticks_++ % kTicksPerState == 0) {
      tell(live_state(controller, trajectory, now));
    }
  }
  void tell(const LiveState& state) { (void)states_.push(state); }

 private:
  void show_all();
  void show(const LiveState& state);
  void show_line(const LiveState& state);

  std::optional<sockaddr_in> receiver_;
  bool has_line_;
  int descriptor_ = -1;
  core::SpscRing<LiveState, 64> states_;
  std::uint32_t ticks_ = 0;
  std::atomic<bool> running_{true};
  std::thread thread_;
  // Of the thread that shows.
  std::uint32_t shown_ = 0;
  std::array<LiveState, 5> former_{};  ///< of the lines of the last second
  std::uint32_t lines_ = 0;
};

}  // namespace m100::companion
