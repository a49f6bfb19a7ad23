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

/// The state that is shown of a tick: a copy, so that the thread that shows it needs nothing of the flight. World
/// frame, SI units.
struct LiveState {
  double t_s = 0.0;
  safety::FailsafeState failsafe_state = safety::FailsafeState::kSilent;
  bool in_control = false;
  bool healthy = false;
  std::array<double, 3> position_m{};
  std::array<double, 3> velocity_m_s{};
  std::array<double, 3> reference_m{};
  std::array<double, 2> tilt_rad{};
  double yaw_rad = 0.0;
  ctl::Command<double> command{};  ///< that the failsafe passes; roll and pitch of the body, forward-left-up
  double pose_age_s = 0.0;         ///< of the newest, since its capture
  double pose_latency_s = 0.0;     ///< least latency of a pose
  double pose_jitter_s = 0.0;      ///< 99th percentile of the latency, minus the least
  std::uint64_t poses = 0;         ///< accepted since the program began
  std::uint64_t poses_lost = 0;
  double telemetry_hz = 0.0;
  double telemetry_age_s = 0.0;  ///< not a number: none has arrived
  est::VibrationStatus vibration{};
  std::uint8_t battery_percent = 0;
};

LiveState live_state(const app::FlightController<double>& controller, const ref::Trajectory<double>& trajectory,
                     core::TimePoint now);
/// One object of JSON, as PlotJuggler's UDP server takes it; its `timestamp` is t_s.
std::string json_of(const LiveState& state);
/// One line: failsafe state, position, distance from the reference, latency and loss of the poses, link. @param
/// lost_share lost poses over sent ones.
std::string status_of(const LiveState& state, double lost_share);

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
  void publish(const app::FlightController<double>& controller, const ref::Trajectory<double>& trajectory,
               core::TimePoint now) {
    if (thread_.joinable() && ticks_++ % kTicksPerState == 0) {
      publish(live_state(controller, trajectory, now));
    }
  }
  void publish(const LiveState& state) { (void)states_.push(state); }

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
  // Used by the thread that shows.
  std::uint32_t shown_ = 0;
  std::array<LiveState, 5> former_{};  ///< shown by the last five lines, of one second
  std::uint32_t lines_ = 0;
};

}  // namespace m100::companion
