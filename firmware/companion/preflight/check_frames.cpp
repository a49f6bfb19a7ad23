// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/preflight/check_frames.h"

#include <array>
#include <iostream>
#include <optional>

#include "firmware/companion/fly/fly.h"
#include "firmware/companion/ground_station/mavlink_tap.h"
#include "firmware/companion/preflight/axis_alignment.h"
#include "firmware/companion/preflight/probe/line_check.h"
#include "firmware/companion/subcommands.h"
#include "firmware/link/pose/pose_decoder.h"
#include "firmware/link/pose/pose_link.h"
#include "protocol/mavlink/pose_messages.h"

namespace m100::companion::preflight {
namespace {

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

std::vector<CheckResult> check_frames(const CheckFramesOptions& options) {
  if (options.port.empty() || options.pose.port.empty()) {
    throw UsageError("--frames: needs --port and --pose-port");
  }
  check(options.pose, options.port);
  watch_signals();
  hal::SerialPort port(options.port, options.baud);
  open_or_explain(port);
  PosePort pose_port(options.pose, options.port);
  const link::SenderChoice choice = choice_of(options.pose);
  AttitudeTap pose_line(pose_port.line(), choice);
  ExchangedPorts exchanged;
  link::PoseLink pose_link(pose_line, pose_port.baud(), &exchanged, choice);
  LineProbe line;
  AxisAlignment frames;
  std::optional<core::Pose<double>> pose;
  std::cout
      << "propellers off; for " << options.hold_s
      << " s: tilt the nose down and up, tilt right and left, turn both ways, then push it back and forth along x, y "
         "and z of the room, each within a second"
      << std::endl;
  TickClock clock(options.port);
  for (core::TimePoint now = clock.now();
       core::seconds<double>(now.time_since_epoch()) < options.hold_s && !stop_requested(); now = clock.next()) {
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
