// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/operator/live_display.h"

#include <arpa/inet.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/text/json.h"
#include "firmware/companion/subcommands.h"

namespace m100::companion {
namespace {

double milliseconds(core::Duration time) { return 1000.0 * core::seconds<double>(time); }

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

bool shows_status(const LiveOptions& options) {
  return options.status == "always" || (options.status == "auto" && isatty(STDOUT_FILENO) == 1);
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

std::string json_of(const app::TickRecord<double>& record) {
  const auto xyz = [](double x, double y, double z) { return Json{{"x", x}, {"y", y}, {"z", z}}; };
  const est::Estimate<double>& at = record.estimate;
  const ctl::Command<double>& command = record.supervised.command;
  const est::VibrationStatus& vibration = record.seen.consistency.vibration;
  return Json{{"timestamp", core::seconds<double>(record.now.time_since_epoch())},
              {"failsafe_state", static_cast<int>(record.supervised.failsafe_state)},
              {"in_control", record.authority.in_control ? 1 : 0},
              {"healthy", at.healthy ? 1 : 0},
              {"position_m", xyz(at.x.position_m, at.y.position_m, at.height_m)},
              {"velocity_m_s", xyz(at.x.velocity_m_s, at.y.velocity_m_s, at.climb_m_s)},
              {"reference_m", xyz(record.course_w_m.x(), record.course_w_m.y(), record.course_w_m.z())},
              {"tilt_rad", {{"x", at.x.tilt_rad}, {"y", at.y.tilt_rad}}},
              {"yaw_rad", at.yaw_rad},
              {"command",
               {{"roll_rad", command.roll_rad},
                {"pitch_rad", command.pitch_rad},
                {"climb_m_s", command.climb_m_s},
                {"yaw_rate_rad_s", command.yaw_rate_rad_s}}},
              {"pose",
               {{"age_s", core::seconds<double>(record.seen.estimate.pose_age)},
                {"latency_s", core::seconds<double>(record.seen.pose_latency.min_latency)},
                {"jitter_s", core::seconds<double>(record.seen.pose_latency.jitter)},
                {"taken", record.poses.poses},
                {"lost", record.poses.lost_frames}}},
              {"link",
               {{"telemetry_hz", record.health.telemetry_rate_hz},
                {"age_s", record.health.packages > 0 ? core::seconds<double>(record.health.telemetry_age)
                                                     : std::numeric_limits<double>::quiet_NaN()}}},
              {"vibration_m_s2", vibration.rms_m_s2},
              {"vibration_peak_m_s2", vibration.peak_m_s2},
              {"vibration_clipped", vibration.clipped},
              {"battery_percent", record.telemetry.battery_percent}}
      .dump();
}

std::string status_of(const app::TickRecord<double>& record, double lost_share) {
  const est::Estimate<double>& at = record.estimate;
  double squared = 0.0;
  for (const double off_m : {at.x.position_m - record.course_w_m.x(), at.y.position_m - record.course_w_m.y(),
                             at.height_m - record.course_w_m.z()}) {
    squared += std::pow(off_m, 2);
  }
  std::array<char, 40> off{"not flown"};
  if (safety::passes_law(record.supervised.failsafe_state)) {
    std::snprintf(off.data(), off.size(), "off %.2f m", std::sqrt(squared));
  }
  std::array<char, 40> link{"no telemetry"};
  if (record.health.packages > 0) {
    std::snprintf(link.data(), link.size(), "link %.0f Hz %.0f ms", record.health.telemetry_rate_hz,
                  milliseconds(record.health.telemetry_age));
  }
  const est::VibrationStatus& seen = record.seen.consistency.vibration;
  std::array<char, 64> vibration{"vibration not seen at this rate"};
  if (!std::isnan(seen.rms_m_s2)) {
    std::snprintf(
        vibration.data(), vibration.size(),
        seen.clipped > 0.0 ? "vibration %.2f, peak %.2f m/s^2, clips %.0f %%" : "vibration %.2f, peak %.2f m/s^2",
        seen.rms_m_s2, seen.peak_m_s2, 100.0 * seen.clipped);
  }
  const std::string_view state = safety::name(record.supervised.failsafe_state);
  std::array<char, 256> line{};
  std::snprintf(line.data(), line.size(), "%-8.*s%6.2f %6.2f %5.2f m, %s, pose %.0f+%.0f ms, lost %.1f %%, %s, %s",
                static_cast<int>(state.size()), state.data(), at.x.position_m, at.y.position_m, at.height_m, off.data(),
                milliseconds(record.seen.pose_latency.min_latency), milliseconds(record.seen.pose_latency.jitter),
                100.0 * lost_share, link.data(), vibration.data());
  return line.data();
}

}  // namespace m100::companion
