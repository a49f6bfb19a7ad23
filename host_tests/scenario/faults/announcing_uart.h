// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <utility>

#include "firmware/core/eigen.h"
#include "firmware/core/frames.h"
#include "hal/uart.h"
#include "protocol/mavlink/parser.h"
#include "protocol/mavlink/pose_messages.h"

namespace m100::scenario {

/// The line of a pose source whose world may jump: it turns each pose into VISION_POSITION_ESTIMATE, moved, turned, and
/// with a reset_counter.
class AnnouncingUart final : public hal::Uart {
 public:
  explicit AnnouncingUart(hal::Uart& inner) : inner_(inner) {}

  /// From now on poses are turned about the world's origin and then moved (NWU). @param announced with a new counter
  void jump(const core::Vector<double, 3>& by_m, double turn_rad, bool announced) {
    const double c = std::cos(turn_rad), s = std::sin(turn_rad);
    shift_m_ = core::Vector<double, 3>(c * shift_m_.x() - s * shift_m_.y(), s * shift_m_.x() + c * shift_m_.y(),
                                       shift_m_.z()) +
               by_m;
    turn_rad_ += turn_rad;
    counter_ = static_cast<std::uint8_t>(counter_ + (announced ? 1 : 0));
  }

  /// From now on the origin of the poses lies beside the aircraft's place, and the poses have its tilt. @param attitude
  /// of the aircraft
  void set_lever_arm(const core::Vector<double, 3>& lever_b_m, std::function<core::Euler<double>()> attitude) {
    lever_b_m_ = lever_b_m;
    attitude_ = std::move(attitude);
  }

  core::Expected<std::size_t> read(std::span<std::byte> destination) override {
    std::array<std::byte, 256> chunk;
    const std::size_t count = inner_.read(chunk).value_or(0);
    parser_.consume(std::span(chunk).first(count), [&](const mavlink::FrameView& frame) { convert(frame); });
    const std::size_t taken = std::min(destination.size(), waiting_.size());
    std::copy_n(waiting_.begin(), taken, destination.begin());
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(taken));
    return taken;
  }
  core::Expected<std::size_t> write(std::span<const std::byte> source) override { return inner_.write(source); }

 private:
  void convert(const mavlink::FrameView& frame) {
    if (!mavlink::is<mavlink::AttPosMocap>(frame)) {
      waiting_.insert(waiting_.end(), frame.bytes.begin(), frame.bytes.end());
      return;
    }
    const auto pose = mavlink::decode<mavlink::AttPosMocap>(frame);
    const double c = std::cos(turn_rad_), s = std::sin(turn_rad_), x = pose.x, y = -static_cast<double>(pose.y);
    const double yaw_rad = -2.0 * static_cast<double>(std::atan2(pose.q[3], pose.q[0])) + turn_rad_;
    core::Euler<double> tilt = attitude_ ? attitude_() : core::Euler<double>{};
    tilt.yaw_rad = yaw_rad;
    const core::Vector<double, 3> origin_m =
        core::rotation_of(core::quaternion_of(tilt)) * lever_b_m_ + shift_m_;  // from the place in the turned world
    const mavlink::Frame moved = mavlink::encode(
        mavlink::VisionPositionEstimate{.usec = pose.time_usec,
                                        .x = static_cast<float>(c * x - s * y + origin_m.x()),
                                        .y = static_cast<float>(-(s * x + c * y + origin_m.y())),
                                        .z = static_cast<float>(static_cast<double>(pose.z) - origin_m.z()),
                                        .roll = static_cast<float>(tilt.roll_rad),
                                        .pitch = static_cast<float>(-tilt.pitch_rad),
                                        .yaw = static_cast<float>(-std::remainder(yaw_rad, 2.0 * core::kPi)),
                                        .reset_counter = counter_},
        frame.from, frame.sequence);
    waiting_.insert(waiting_.end(), moved.bytes().begin(), moved.bytes().end());
  }

  hal::Uart& inner_;
  mavlink::Parser parser_;
  std::deque<std::byte> waiting_;
  core::Vector<double, 3> shift_m_ = core::Vector<double, 3>::Zero();
  double turn_rad_ = 0.0;
  core::Vector<double, 3> lever_b_m_ = core::Vector<double, 3>::Zero();
  std::function<core::Euler<double>()> attitude_;
  std::uint8_t counter_ = 0;
};

}  // namespace m100::scenario
