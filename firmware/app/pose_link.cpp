// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/pose_link.h"

#include <array>

namespace m100::app {
namespace {

constexpr std::int64_t kBitsPerByte = 10;
constexpr core::Duration kSenderGone = std::chrono::seconds(1);

core::Duration line_time(std::uint32_t baud) {
  const std::int64_t bits = std::int64_t{protocol::kPoseMessageBytes} * kBitsPerByte;
  return baud == 0 ? core::Duration{0} : core::Duration{bits * 1000000 / baud};
}

}  // namespace

PoseLink::PoseLink(hal::Uart& uart, std::uint32_t baud, ByteTap* tap)
    : uart_(uart), line_time_(line_time(baud)), tap_(tap) {}

bool PoseLink::accept(std::uint32_t sequence, core::TimePoint now) {
  const auto step = static_cast<std::int32_t>(sequence - last_sequence_);  // signed: the number may wrap
  const bool restarted = !has_last_ || step < -static_cast<std::int32_t>(kRestart) || now - last_time_ > kSenderGone;
  if (!restarted && step <= 0) {
    ++refused_sequences_;
    return false;
  }
  lost_messages_ += restarted ? 0U : static_cast<std::uint32_t>(step) - 1U;
  has_last_ = true;
  last_sequence_ = sequence;
  last_time_ = now;
  return true;
}

core::Expected<PoseSample> PoseLink::receive(core::TimePoint now) {
  core::Expected<PoseSample> newest = core::Status::kNotReady;
  std::array<std::byte, 256> chunk;
  for (std::size_t visit = 0; visit < kBytesPerTick / chunk.size(); ++visit) {
    const core::Expected<std::size_t> count = uart_.read(chunk);
    if (!count || *count == 0) {
      break;
    }
    const std::span<const std::byte> bytes = std::span(chunk).first(*count);
    if (tap_ != nullptr) {
      tap_->received(bytes, now);
    }
    for (std::span<const std::byte> rest = bytes; !rest.empty();) {
      if (!parser_.take(rest)) {
        continue;
      }
      const core::Expected<protocol::PoseMessage> message = parser_.judge();
      if (message && accept(message->sequence, now)) {
        newest = PoseSample{.message = *message, .age = core::Duration{message->age_us} + line_time_};
      }
    }
  }
  return newest;
}

}  // namespace m100::app
