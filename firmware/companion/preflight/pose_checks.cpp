// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/preflight/pose_checks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <optional>
#include <sstream>

#include "firmware/companion/fly/fly.h"
#include "firmware/companion/fly/pose_port.h"
#include "firmware/companion/ground_station/mavlink_tap.h"
#include "firmware/companion/operator/pose_monitor.h"
#include "firmware/companion/preflight/axis_alignment.h"
#include "firmware/companion/preflight/probe/line_check.h"
#include "firmware/companion/subcommands.h"
#include "firmware/link/pose/pose_decoder.h"
#include "firmware/link/pose/pose_link.h"
#include "protocol/mavlink/pose_messages.h"

namespace m100::companion::preflight {
namespace {

constexpr double kListen_s = 2.0;
constexpr double kMaxLostShare = 0.05;
constexpr double kBitsPerByte = 10.0;

/// Judges the poses received in kListen_s.
CheckResult judge(const link::PoseLink& link, const PosePort& port, const ExchangedPorts& exchanged,
                  const PosePlan& line) {
  const link::PoseLinkStats& seen = link.stats();
  CheckResult check{.name = "poses", .health = Health::kGood, .finding = "", .remedy = ""};
  const double rate_hz = static_cast<double>(seen.poses) / kListen_s;
  const double lost = static_cast<double>(seen.lost_frames) /
                      std::max(1.0, static_cast<double>(link.parser_stats().frames + seen.lost_frames));
  std::ostringstream finding;
  finding << std::lround(rate_hz) << " a second, " << std::lround(100.0 * lost) << " % of the frames lost";
  if (!hal::is_udp(line.source.port)) {
    const double share = static_cast<double>(link.parser_stats().bytes) * kBitsPerByte / (kListen_s * line.source.baud);
    finding << ", " << std::lround(100.0 * share) << " % of " << line.source.baud << " baud";
    if (share > mavlink::kMaxPoseShare) {
      check.health = Health::kBad;
      check.remedy = "use a higher baud rate, fewer poses, or ATT_POS_MOCAP without its covariance";
    }
  }
  if (port.signatures() != nullptr) {
    finding << "; " << describe(*port.signatures());
  }
  if (seen.poses == 0) {
    finding.str("none came; " + why_no_pose(link, port, exchanged));
    check.health = Health::kBad;
    check.remedy = "check the source of pose";
  } else if (link.senders().all().size() > 1 && line.source.from.empty()) {
    finding << "; from several senders: " << describe(link.senders());
    check.health = Health::kBad;
    check.remedy = "choose one with --pose-from SYS:COMP";
  } else if (const std::string refusals = describe_refusals(seen); !refusals.empty()) {
    finding << "; refused: " << refusals;
    check.health = Health::kDoubtful;
    check.remedy = "mend what the source sends";
  } else if (check.health == Health::kGood && (rate_hz < PoseMonitor::kMinPoses_hz || lost > kMaxLostShare)) {
    check.health = Health::kDoubtful;
    check.remedy = "send 50 poses a second or more, over a line that loses none";
  }
  check.finding = finding.str();
  return check;
}

core::Quaternion<double> quaternion(const std::array<float, 4>& q) {
  return {static_cast<double>(q[0]), static_cast<double>(q[1]), static_cast<double>(q[2]), static_cast<double>(q[3])};
}

/// Keeps the attitude of the newest pose, of which a flight uses only the heading.
class AttitudeTap final : public MavlinkTap {
 public:
  AttitudeTap(hal::Uart& line, link::SenderChoice choice) : MavlinkTap(line), choice_(choice) {}
  /// Body FLU to world NWU.
  const core::Quaternion<double>& attitude() const { return attitude_; }

 private:
  void receive(const mavlink::FrameView& frame) override {
    link::PoseAside beside;
    if (!choice_.admits(frame.from) || !link::decode_pose(frame, beside)) {  // a flight would refuse it, too
      return;
    }
    if (mavlink::is<mavlink::AttPosMocap>(frame)) {
      attitude_ = core::flip_yz(quaternion(mavlink::decode<mavlink::AttPosMocap>(frame).q));
    } else if (mavlink::is<mavlink::Odometry>(frame)) {
      attitude_ = core::flip_yz(quaternion(mavlink::decode<mavlink::Odometry>(frame).q));
    } else {
      const auto seen = mavlink::decode<mavlink::VisionPositionEstimate>(frame);
      attitude_ = core::flip_yz(core::quaternion_of(core::Euler<double>{
          static_cast<double>(seen.roll), static_cast<double>(seen.pitch), static_cast<double>(seen.yaw)}));
    }
  }

  link::SenderChoice choice_;
  core::Quaternion<double> attitude_{};
};

AxisAlignment::Sample sample_of(const core::Pose<double>& pose, const core::Quaternion<double>& pose_wb,
                                const protocol::Telemetry& telemetry, core::TimePoint now) {
  const std::array<float, 3>& f = telemetry.acceleration;
  return {.at = now,
          .position_w_m = pose.position_w_m,
          .pose_wb = pose_wb,
          .autopilot_wb = core::flip_yz(quaternion(telemetry.attitude)),
          .force_b = {static_cast<double>(f[0]), -static_cast<double>(f[1]), -static_cast<double>(f[2])}};
}

}  // namespace

std::vector<std::string> pose_messages() {
  std::vector<std::string> names;
  names.reserve(std::size(mavlink::kPoseWires));
  for (const mavlink::PoseWire& wire : mavlink::kPoseWires) {
    names.emplace_back(wire.name);
  }
  return names;
}

CheckResult check_pose_line(const PosePlan& line) {
  mavlink::PoseWire wire = *std::find_if(mavlink::kPoseWires.begin(), mavlink::kPoseWires.end(),
                                         [&](const auto& one) { return one.name == line.message; });
  wire.bytes += line.source.key_file.empty() ? 0 : mavlink::kSignatureBytes;
  const double share = mavlink::line_share(wire, line.rate_hz, line.source.baud);
  std::ostringstream finding;
  finding << wire.name << " (" << wire.bytes << " bytes) at " << line.rate_hz << " Hz takes "
          << std::lround(100.0 * share) << " % of " << line.source.baud << " baud";
  const bool fits = share <= mavlink::kMaxPoseShare;
  return {"pose line", fits ? Health::kGood : Health::kBad, finding.str(),
          fits ? "" : "use a higher baud rate, fewer poses, or ATT_POS_MOCAP without its covariance"};
}

std::vector<CheckResult> check_pose_port(const PosePlan& line, const std::string& autopilot) {
  const PoseOptions& options = line.source;
  if (options.port.empty()) {
    return {};
  }
  const std::string name = "pose port " + options.port;
  try {
    check(options, autopilot.empty() ? options.port + "?" : autopilot);
    PosePort port(options, options.port);
    ExchangedPorts exchanged;
    link::PoseLink link(port.line(), port.baud(), &exchanged, choice_of(options));
    TickClock clock(options.port, [&] { port.mark_arrived(); });
    for (core::TimePoint now = clock.now(); core::seconds<double>(now.time_since_epoch()) < kListen_s;
         now = clock.next()) {
      port.tick();
      (void)link.receive(now);
    }
    return {{name, Health::kGood, options.key_file.empty() ? "opens" : "opens, and the key can be read", ""},
            judge(link, port, exchanged, line)};
  } catch (const UsageError& error) {  // of the port or of the key: its message holds the remedy
    return {{name, Health::kBad, error.what(), "do what the finding says"}};
  }
}

std::vector<CheckResult> check_frames(const std::string& autopilot, std::uint32_t baud, const PoseOptions& pose_options,
                                      double hold_s) {
  if (autopilot.empty() || pose_options.port.empty()) {
    throw UsageError("--frames: needs --port and --pose-port");
  }
  check(pose_options, autopilot);
  watch_signals();
  hal::SerialPort port(autopilot, baud);
  open_or_explain(port);
  PosePort pose_port(pose_options, autopilot);
  const link::SenderChoice choice = choice_of(pose_options);
  AttitudeTap pose_line(pose_port.line(), choice);
  ExchangedPorts exchanged;
  link::PoseLink pose_link(pose_line, pose_port.baud(), &exchanged, choice);
  LineProbe line;
  AxisAlignment frames;
  std::optional<core::Pose<double>> pose;
  std::cout
      << "propellers off; for " << hold_s
      << " s: tilt the nose down and up, tilt right and left, turn both ways, then push it back and forth along x, y "
         "and z of the room, each within a second"
      << std::endl;
  TickClock clock(autopilot);
  for (core::TimePoint now = clock.now(); core::seconds<double>(now.time_since_epoch()) < hold_s && !stop_requested();
       now = clock.next()) {
    pose_port.tick();
    (void)receive_telemetry(port, line);
    if (const core::Expected<core::Pose<double>> newest = pose_link.receive(now)) {
      pose = *newest;
    }
    if (pose && line.has_attitude_and_force()) {
      frames.add(sample_of(*pose, pose_line.attitude(), line.telemetry(), now));
    }
  }
  if (!pose) {
    return {{"frames", Health::kBad, "no pose came; " + why_no_pose(pose_link, pose_port, exchanged),
             "check the source of pose"}};
  }
  if (!choice.is_made() && pose_link.stats().refused_senders > 0) {
    return {{"frames", Health::kBad, "poses come from several senders: " + describe(pose_link.senders()),
             "choose one with --pose-from SYS:COMP"}};
  }
  if (frames.samples() == 0) {
    return {missing_telemetry(line, "frames", Health::kBad)};
  }
  return frames.checks();
}

}  // namespace m100::companion::preflight
