// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/ports/pose_sender.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "protocol/mavlink/pose_messages.h"

namespace m100::sim {
namespace {

/// The sender of poses: system 1, component MAV_COMP_ID_VISUAL_INERTIAL_ODOMETRY.
constexpr mavlink::Address kSource{.system = 1, .component = 197};
constexpr std::int64_t kNsPerUs = 1000;
constexpr std::int64_t kByte_ns = 10 * std::int64_t{1000000000} / 115200;  // as hal::UartPair counts it

core::Duration duration_of(double seconds) { return core::Duration(std::llround(seconds * 1e6)); }

}  // namespace

std::optional<core::TimePoint> PoseSender::send(std::span<const std::byte> bytes, core::TimePoint now) {
  const std::size_t count = uart_.write(bytes).value_or(0);
  const std::int64_t now_ns = std::chrono::nanoseconds(now.time_since_epoch()).count();
  line_free_ns_ = std::max(line_free_ns_, now_ns) + static_cast<std::int64_t>(count) * kByte_ns;
  if (count != bytes.size()) {
    return std::nullopt;
  }
  return core::TimePoint(std::chrono::duration_cast<core::Duration>(std::chrono::nanoseconds(line_free_ns_)));
}

core::TimePoint PoseSender::newest_captured(core::TimePoint now) {
  for (; !on_line_.empty() && on_line_.front().passed <= now; on_line_.pop_front()) {
    newest_captured_ = std::max(newest_captured_, on_line_.front().captured);
  }
  return newest_captured_;
}

void PoseSender::answer_time_requests(core::TimePoint now) {
  std::array<std::byte, 256> chunk;
  const std::size_t count = uart_.read(chunk).value_or(0);
  parser_.consume(std::span(chunk).first(count), [&](const mavlink::FrameView& frame) {
    if (!source_.tells_time() || !mavlink::is<mavlink::Timesync>(frame)) {
      return;
    }
    const auto question = mavlink::decode<mavlink::Timesync>(frame);
    if (question.tc1 == 0) {
      const core::TimePoint received = now + duration_of(source_.numbers().sync_out_s);
      requests_.push_back({question.ts1, received, received + duration_of(source_.numbers().sync_back_s)});
    }
  });
  for (; !requests_.empty() && requests_.front().answered <= now; requests_.pop_front()) {
    const TimeRequest& question = requests_.front();
    const std::int64_t own_ns = source_.own_time(question.received).time_since_epoch().count() * kNsPerUs;
    static_cast<void>(
        send(encode(mavlink::Timesync{.tc1 = own_ns, .ts1 = question.ts1}, kSource, frames_++).bytes(), now));
  }
}

void PoseSender::step(core::TimePoint now, const VehiclePort& vehicle, core::TimePoint moved_at) {
  answer_time_requests(now);
  while (const auto sample = source_.step(now, vehicle.state(), vehicle.attitude().yaw_rad, moved_at)) {
    // World NWU and body FLU as NED and FRD: y and z change sign, and with them the turn about z.
    const double half_yaw = -0.5 * sample->yaw_rad;
    const mavlink::AttPosMocap message{
        .time_usec = static_cast<std::uint64_t>(sample->stamp.time_since_epoch().count()),
        .q = {static_cast<float>(std::cos(half_yaw)), 0.0F, 0.0F, static_cast<float>(std::sin(half_yaw))},
        .x = static_cast<float>(sample->position_w_m.x()),
        .y = static_cast<float>(-sample->position_w_m.y()),
        .z = static_cast<float>(-sample->position_w_m.z())};
    if (const auto passed = send(encode(message, kSource, frames_++).bytes(), now)) {
      on_line_.push_back({*passed, sample->captured});
    }
    static_cast<void>(newest_captured(now));  // removes the poses that have passed, so that the list stays short
  }
}

}  // namespace m100::sim
