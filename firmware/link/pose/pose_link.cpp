// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/pose/pose_link.h"

#include <array>

#include "firmware/core/frames.h"
#include "firmware/link/line_time.h"
#include "firmware/link/pose/pose_decoder.h"

namespace m100::link {
namespace {

constexpr std::uint64_t kRoomForAnswer = 56;  // bytes: an answer of 28, and as much again to catch up
constexpr float kUpMean = 1.F / 16.F;         // weight of a new attitude in its mean
constexpr core::Duration kSenderGone = std::chrono::seconds(1);
/// System 1 is the aircraft, component 191 its companion computer.
constexpr mavlink::Address kOurs{.system = 1, .component = 191};

/// The weight of a new direction in its mean: the first one is taken whole.
float share_of_new(const core::Vector<float, 3>& mean) { return mean.isZero(0.F) ? 1.F : kUpMean; }

/// False for a NaN, too.
bool is_within(const core::Vector<double, 3>& variance_m2, const std::array<double, 3>& max_m2) {
  return variance_m2.x() <= max_m2[0] && variance_m2.y() <= max_m2[1] && variance_m2.z() <= max_m2[2];
}

}  // namespace

PoseLink::PoseLink(hal::Uart& uart, std::uint32_t baud, ByteTap* tap, SenderChoice choice,
                   const PoseProperties& properties)
    : uart_(uart), baud_(baud), tap_(tap), choice_(choice), properties_(properties) {}

void PoseLink::refuse(PoseFault fault, core::TimePoint now) {
  ++stats_.faults[static_cast<std::size_t>(fault)];
  stats_.last_fault = fault;
  stats_.last_fault_at = now;
  if (fault == PoseFault::kSender) {
    ++stats_.refused_senders;
  } else if (fault == PoseFault::kOrder) {
    ++stats_.refused_order;
  } else {
    ++stats_.refused;
  }
}

bool PoseLink::is_from_sender(const mavlink::FrameView& frame, core::TimePoint now) {
  const bool is_locked = has_last_ && frame.from != sender_ && now - last_time_ <= kSenderGone;
  if (is_locked || !choice_.admits(frame.from)) {
    return false;
  }
  const auto step = static_cast<std::uint8_t>(frame.sequence - last_.frame);
  constexpr std::uint8_t kLargestGap = 128;  // a larger step is a new count, not a loss
  if (has_last_ && frame.from == sender_ && step > 0 && step < kLargestGap) {
    stats_.lost_frames += step - 1U;
  }
  last_.frame = frame.sequence;
  return true;
}

/// The variance along each axis: the operator's, if he states one, or the sender's.
core::Vector<double, 3> PoseLink::stated_variance_m2(const core::Pose<double>& pose) {
  core::Vector<double, 3> variance_m2 = pose.position_variance_m2;
  if (properties_.sigma_m > 0.0) {
    variance_m2.setConstant(properties_.sigma_m * properties_.sigma_m);
  }
  stats_.last_variance_m2 = variance_m2.maxCoeff();
  return variance_m2;
}

bool PoseLink::accept(const core::Pose<double>& pose, std::uint8_t frame, core::TimePoint now) {
  const bool stamped = pose.captured != core::SenderTime{};
  if (stamped || is_stamped_) {  // after a stamped pose, one without a stamp has the stamp 0, which goes back
    const PoseFault unit = unit_.judge(pose.captured, now);
    const StampOrder::Verdict verdict = order_.judge(pose.captured, frame, now);
    if (unit != PoseFault::kNone || verdict == StampOrder::Verdict::kRefused) {
      refuse(unit != PoseFault::kNone ? unit : PoseFault::kOrder, now);
      return false;
    }
    clock_was_set_ = clock_was_set_ || verdict == StampOrder::Verdict::kSet;
    is_stamped_ = stamped;
  }
  has_last_ = true;
  last_time_ = now;
  ++stats_.poses;
  return true;
}

/// A sender may mix kinds of messages: one without a counter announces nothing and leaves the last one.
void PoseLink::count_jump(std::optional<std::uint8_t> counter, bool is_same_sender) {
  last_.reset_counter = is_same_sender ? last_.reset_counter : std::nullopt;
  if (counter) {
    stats_.announced_jumps += static_cast<std::uint32_t>(counter != last_.reset_counter.value_or(*counter));
    last_.reset_counter = counter;
  }
}

void PoseLink::take(const mavlink::FrameView& frame, core::TimePoint now, Newest& newest) {
  const std::uint64_t end = frame.offset + frame.bytes.size();
  const bool is_same_sender = has_last_ && frame.from == sender_;
  if (mavlink::is<mavlink::Timesync>(frame)) {
    const auto message = mavlink::decode<mavlink::Timesync>(frame);
    if (!is_same_sender || !is_from_sender(frame, now)) {
      return;
    }
    if (message.tc1 == 0) {
      newest.question_ts1 = message.ts1;
      return;
    }
    newest.ts1 = message.ts1;
    newest.theirs = message.tc1;
    newest.answer_end = end;
    return;
  }
  PoseAside beside;
  const core::Expected<core::Pose<double>> pose = decode_pose(frame, beside);
  if (pose.status() == core::Status::kNotReady) {
    if (is_same_sender) {
      (void)is_from_sender(frame,
                           now);  // another message: its sequence number counts, so that no frame seems to be lost
    }
    return;
  }
  senders_.add(frame.from, now);
  if (!is_from_sender(frame, now)) {
    return refuse(PoseFault::kSender, now);
  }
  if (!pose) {
    return refuse(beside.fault, now);
  }
  const core::Vector<double, 3> variance_m2 = stated_variance_m2(*pose);
  if (!is_within(variance_m2, properties_.max_variance_m2)) {
    return refuse(PoseFault::kVariance, now);
  }
  if (has_last_ && !is_same_sender) {
    comparison_.reset();
    order_.reset();
    unit_ = {};
    up_b_.setZero();
    is_stamped_ = false;
  }
  if (accept(*pose, frame.sequence, now)) {
    sender_ = frame.from;
    count_jump(beside.reset_counter, is_same_sender);
    up_b_ += (core::up_in_body(beside.flu_in_nwu) - up_b_) * share_of_new(up_b_);
    newest.pose = *pose;
    const auto& [forward_m, left_m, up_m] = properties_.offset_b_m;
    const core::Vector<float, 3> origin_m =
        core::rotation_of(beside.flu_in_nwu) * core::Vector<float, 3>(forward_m, left_m, up_m);
    newest.pose.position_w_m -= origin_m.cast<double>();
    newest.pose.position_variance_m2 = variance_m2;
    newest.pose_end = end;
  }
}

core::Expected<core::Pose<double>> PoseLink::receive(core::TimePoint now) {
  Newest newest;
  std::array<std::byte, 64> chunk;  // a pose; larger costs stack in every tick
  for (std::size_t visit = 0; visit < kBytesPerTick / chunk.size(); ++visit) {
    const core::Expected<std::size_t> count = uart_.read(chunk);
    if (!count || *count == 0) {
      break;
    }
    const std::span<const std::byte> bytes = std::span(chunk).first(*count);
    if (tap_ != nullptr) {
      tap_->received(bytes, now);
    }
    parser_.consume(bytes, [&](const mavlink::FrameView& frame) { take(frame, now, newest); });
  }
  // Bytes after a frame in the stream arrived after it.
  const std::uint64_t all = parser_.stats().bytes;
  if (newest.answer_end > 0 &&
      comparison_.answer(newest.ts1, newest.theirs, now - line_time(all - newest.answer_end, baud_))) {
    ++stats_.answers;
  }
  if (newest.question_ts1) {
    const std::chrono::nanoseconds ours = now.time_since_epoch();
    send({.tc1 = ours.count(), .ts1 = *newest.question_ts1}, now);
  }
  if (newest.pose_end == 0) {
    return core::Status::kNotReady;
  }
  core::Pose<double> pose = newest.pose;
  pose.sequence = static_cast<std::uint32_t>(stats_.poses);
  pose.arrived = now - line_time(all - newest.pose_end, baud_);
  pose.clock_was_set = clock_was_set_;
  clock_was_set_ = false;
  if (pose.captured == core::SenderTime{}) {
    pose.set_captured_at(pose.arrived);
    return pose;
  }
  pose.to_ours = pose.arrived.time_since_epoch() - core::Duration(pose.captured.time_since_epoch().count());
  pose.offset = comparison_.offset(now);
  return pose;
}

/// Whether the line has had room for one more answer since the last question. On a full line each answer delays all
/// later poses: 240 poses of 48 bytes a second fill 115200 baud, and five answers a second let the queue grow by 12 ms
/// a second.
bool PoseLink::has_room(core::TimePoint now) const {
  const core::Duration busy = line_time(parser_.stats().bytes - time_messages_.last_at_bytes, baud_);
  return comparison_.since_request(now) - busy >= line_time(kRoomForAnswer, baud_);
}

void PoseLink::request_time(core::TimePoint now) {
  if (!comparison_.due(now) || (comparison_.is_known() && !has_room(now))) {
    return;
  }
  time_messages_.last_at_bytes = parser_.stats().bytes;
  send({.tc1 = 0, .ts1 = comparison_.request(now)}, now);
}

void PoseLink::send(const mavlink::Timesync& message, core::TimePoint now) {
  const mavlink::Frame frame = mavlink::encode(message, kOurs, time_messages_.count++);
  const core::Expected<std::size_t> taken = uart_.write(frame.bytes());
  if (taken && *taken > 0 && tap_ != nullptr) {
    tap_->sent(frame.bytes().first(*taken), now);
  }
}

}  // namespace m100::link
