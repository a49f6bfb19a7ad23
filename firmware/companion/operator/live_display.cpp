// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/operator/live_display.h"

#include <arpa/inet.h>
#include <malloc.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/text/json.h"
#include "firmware/companion/operator/terminal.h"
#include "firmware/companion/subcommands.h"

namespace m100::companion {
namespace {

constexpr auto kLook = std::chrono::milliseconds(10);
constexpr std::string_view kBegin = "\r\x1b[K";  ///< cursor to the left end, line erased
constexpr std::size_t kNoEnd = 1000;             ///< columns if the output is not a terminal
std::atomic<bool> line_stands{false};

/// Columns that a line may have: one less than the terminal, because a longer line could not be erased.
std::size_t columns() {
  winsize size{};
  return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col - 1U : kNoEnd;
}

double milliseconds(double seconds) { return 1000.0 * seconds; }

}  // namespace

void add_live_options(const Subcommand& app, LiveOptions& options) {
  app.add_option("--live", options.to,
                 "send the state of the flight as JSON over UDP, 50 times a second, unsigned, to HOST:PORT; HOST is an "
                 "IPv4 address; default: off. Example, for PlotJuggler on this machine: --live 127.0.0.1:9870");
  app.add_option("--status", options.status,
                 "show a line on the terminal with failsafe state, position, error, pose and link; auto: if the "
                 "standard output is a terminal. Example: --status never")
      .one_of({"auto", "always", "never"});
}

std::optional<sockaddr_in> receiver_of(const std::string& text) {
  if (text.empty()) {
    return {};
  }
  const std::size_t colon = text.rfind(':');
  const std::string host = text.substr(0, colon);
  const std::string port = colon == std::string::npos ? "" : text.substr(colon + 1);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  const bool is_number = !port.empty() && port.size() <= 5 && port.find_first_not_of("0123456789") == std::string::npos;
  const unsigned long number = is_number ? std::stoul(port) : 0;
  if (number == 0 || number > 0xFFFFU || inet_pton(AF_INET, host.c_str(), &address.sin_addr) != 1) {
    throw UsageError("--live: " + text + ": is not an IPv4 address and port, as in 127.0.0.1:9870");
  }
  address.sin_port = htons(static_cast<std::uint16_t>(number));
  return address;
}

LiveState live_state(const app::FlightController<double>& controller, const ref::Trajectory<double>& trajectory,
                     core::TimePoint now) {
  const est::Estimate<double>& estimate = controller.estimate();
  const ref::Window<double> window = trajectory.window(now, core::Duration{0});
  const link::PoseLinkStats& poses = controller.pose_link().stats();
  const link::LinkHealth& health = controller.link().health();
  const est::PoseTimingReport<double>& timing = controller.pose_timing();
  return {.t_s = core::seconds<double>(now.time_since_epoch()),
          .failsafe_state = controller.supervisor().failsafe_state(),
          .in_control = controller.link().authority().in_control,
          .healthy = estimate.healthy,
          .position_m = {estimate.x.position_m, estimate.y.position_m, estimate.height_m},
          .velocity_m_s = {estimate.x.velocity_m_s, estimate.y.velocity_m_s, estimate.climb_m_s},
          .reference_m = {window.x[0].position_m, window.y[0].position_m, window.height.position_m},
          .tilt_rad = {estimate.x.tilt_rad, estimate.y.tilt_rad},
          .yaw_rad = estimate.yaw_rad,
          .command = controller.grant().command,
          .pose_age_s = core::seconds<double>(controller.observed().estimate.pose_age),
          .pose_latency_s = core::seconds<double>(timing.min_latency),
          .pose_jitter_s = core::seconds<double>(timing.jitter),
          .poses = poses.poses,
          .poses_lost = poses.lost_frames,
          .telemetry_hz = health.telemetry_rate_hz,
          .telemetry_age_s = health.packages > 0 ? core::seconds<double>(health.telemetry_age)
                                                 : std::numeric_limits<double>::quiet_NaN(),
          .vibration = controller.observed().consistency.vibration,
          .battery_percent = controller.link().telemetry().battery_percent};
}

std::string json_of(const LiveState& state) {
  const auto xyz = [](const std::array<double, 3>& v) { return Json{{"x", v[0]}, {"y", v[1]}, {"z", v[2]}}; };
  const auto xy = [](const std::array<double, 2>& v) { return Json{{"x", v[0]}, {"y", v[1]}}; };
  return Json{{"timestamp", state.t_s},
              {"failsafe_state", static_cast<int>(state.failsafe_state)},
              {"in_control", state.in_control ? 1 : 0},
              {"healthy", state.healthy ? 1 : 0},
              {"position_m", xyz(state.position_m)},
              {"velocity_m_s", xyz(state.velocity_m_s)},
              {"reference_m", xyz(state.reference_m)},
              {"tilt_rad", xy(state.tilt_rad)},
              {"yaw_rad", state.yaw_rad},
              {"command",
               {{"roll_rad", state.command.roll_rad},
                {"pitch_rad", state.command.pitch_rad},
                {"climb_m_s", state.command.climb_m_s},
                {"yaw_rate_rad_s", state.command.yaw_rate_rad_s}}},
              {"pose",
               {{"age_s", state.pose_age_s},
                {"latency_s", state.pose_latency_s},
                {"jitter_s", state.pose_jitter_s},
                {"taken", state.poses},
                {"lost", state.poses_lost}}},
              {"link", {{"telemetry_hz", state.telemetry_hz}, {"age_s", state.telemetry_age_s}}},
              {"vibration_m_s2", state.vibration.rms_m_s2},
              {"vibration_peak_m_s2", state.vibration.peak_m_s2},
              {"vibration_clipped", state.vibration.clipped},
              {"battery_percent", state.battery_percent}}
      .dump();
}

std::string status_of(const LiveState& state, double lost_share) {
  double squared = 0.0;
  for (std::size_t axis = 0; axis < state.position_m.size(); ++axis) {
    squared += std::pow(state.position_m[axis] - state.reference_m[axis], 2);
  }
  const bool flies =
      state.failsafe_state == safety::FailsafeState::kNominal || state.failsafe_state == safety::FailsafeState::kCoast;
  std::array<char, 40> off{"not flown"};
  if (flies) {
    std::snprintf(off.data(), off.size(), "off %.2f m", std::sqrt(squared));
  }
  std::array<char, 40> link{"no telemetry"};
  if (!std::isnan(state.telemetry_age_s)) {
    std::snprintf(link.data(), link.size(), "link %.0f Hz %.0f ms", state.telemetry_hz,
                  milliseconds(state.telemetry_age_s));
  }
  std::array<char, 64> vibration{"vibration not seen at this rate"};
  if (!std::isnan(state.vibration.rms_m_s2)) {
    std::snprintf(vibration.data(), vibration.size(),
                  state.vibration.clipped > 0.0 ? "vibration %.2f, peak %.2f m/s^2, clips %.0f %%"
                                                : "vibration %.2f, peak %.2f m/s^2",
                  state.vibration.rms_m_s2, state.vibration.peak_m_s2, 100.0 * state.vibration.clipped);
  }
  std::array<char, 256> line{};
  std::snprintf(line.data(), line.size(), "%-8.*s%6.2f %6.2f %5.2f m, %s, pose %.0f+%.0f ms, lost %.1f %%, %s, %s",
                static_cast<int>(safety::name(state.failsafe_state).size()), safety::name(state.failsafe_state).data(),
                state.position_m[0], state.position_m[1], state.position_m[2], off.data(),
                milliseconds(state.pose_latency_s), milliseconds(state.pose_jitter_s), 100.0 * lost_share, link.data(),
                vibration.data());
  return line.data();
}

std::string_view line_begin() { return line_stands ? kBegin : ""; }

LiveDisplay::LiveDisplay(const LiveOptions& options)
    : receiver_(receiver_of(options.to)),
      has_line_(options.status == "always" || (options.status == "auto" && isatty(STDOUT_FILENO) == 1)) {
  if (receiver_) {
    descriptor_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  }
}

void LiveDisplay::start() {
  if (!receiver_ && !has_line_) {
    return;
  }
  // Otherwise malloc would give this thread an arena of its own: 64 MB of addresses, all of which count as locked
  // memory. The thread that flies allocates nothing from the shared arena, so neither thread waits for the other.
  (void)mallopt(M_ARENA_MAX, 1);
  line_stands = has_line_;
  thread_ = std::thread([this] {
    while (running_) {
      show_all();
      std::this_thread::sleep_for(kLook);
    }
    show_all();
    if (has_line_) {
      write_nonblocking(STDOUT_FILENO, kBegin);
    }
  });
}

void LiveDisplay::finish() {
  running_ = false;
  if (thread_.joinable()) {
    thread_.join();
    line_stands = false;
  }
  if (descriptor_ >= 0) {
    ::close(descriptor_);
    descriptor_ = -1;
  }
}

void LiveDisplay::show_all() {
  LiveState state;
  while (states_.pop(state)) {
    show(state);
  }
}

void LiveDisplay::show(const LiveState& state) {
  if (descriptor_ >= 0) {
    const std::string text = json_of(state);
    (void)!::sendto(descriptor_, text.data(), text.size(), 0, reinterpret_cast<const sockaddr*>(&*receiver_),
                    sizeof(*receiver_));  // a packet that cannot be sent is lost, as on any network
  }
  if (has_line_ && shown_ % kStatesPerLine == 0) {
    show_line(state);
  }
  ++shown_;
}

void LiveDisplay::show_line(const LiveState& state) {
  LiveState& former = former_[lines_++ % former_.size()];
  const auto lost = static_cast<double>(state.poses_lost - former.poses_lost);
  const auto came = static_cast<double>(state.poses - former.poses);
  former = state;
  const std::string line = status_of(state, lost / std::max(1.0, lost + came));
  write_nonblocking(STDOUT_FILENO, std::string(kBegin) + line.substr(0, columns()));
}

}  // namespace m100::companion
