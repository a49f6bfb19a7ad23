// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/autopilot/n1_line.h"

#include <algorithm>

#include "protocol/dji/frame_encoder.h"
#include "protocol/dji/session.h"

namespace m100::sim {
namespace {

constexpr double kBitsPerByte = 10.0;
constexpr std::size_t kReadBytes = 1024;

}  // namespace

N1Line::N1Line(hal::Uart& uart, std::uint32_t baud, std::uint64_t seed)
    : uart_(uart), bytes_per_s_(baud / kBitsPerByte), random_(seed, "n1_line") {
  queue_.reserve(kBufferBytes);
  received_.resize(kReadBytes);
}

std::size_t N1Line::Meter::allow(core::TimePoint now, double bytes_per_s, bool idle) {
  const double earned = core::seconds<double>(now - last) * bytes_per_s;
  last = now;
  allowance = idle ? std::min(allowance + earned, 1.0) : allowance + earned;
  return static_cast<std::size_t>(allowance);
}

void N1Line::enqueue(std::span<const std::byte> bytes) { queue_.insert(queue_.end(), bytes.begin(), bytes.end()); }

bool N1Line::send(std::span<const std::byte> frame, core::TimePoint now) {
  pump(now);
  if (loses_incoming() || queue_.size() + frame.size() > kBufferBytes) {
    return false;
  }
  enqueue(frame);
  pump(now);
  return true;
}

void N1Line::push(protocol::MessageId id, std::span<const std::byte> value, core::TimePoint now) {
  std::array<std::byte, kFrameBytes> space;
  const core::Expected<std::span<const std::byte>> frame = protocol::encode_frame(
      {.session = protocol::kUnansweredSession, .is_ack = false, .encrypted = false, .sequence = push_sequence_}, &id,
      value, space);
  ++push_sequence_;
  if (frame) {
    (void)send(*frame, now);
  }
}

void N1Line::send_later(std::span<const std::byte> frame, core::TimePoint when) {
  const auto free = std::find_if(late_.begin(), late_.end(), [](const Late& late) { return !late.used; });
  if (free == late_.end() || frame.size() > kFrameBytes) {
    return;
  }
  *free = {.used = true, .when = when, .size = frame.size(), .bytes = {}};
  std::copy(frame.begin(), frame.end(), free->bytes.begin());
}

void N1Line::make_noise(std::size_t bytes) {
  for (std::size_t i = 0; i < bytes && queue_.size() < kBufferBytes; ++i) {
    queue_.push_back(static_cast<std::byte>(random_.next() >> 56U));
  }
}

void N1Line::pump(core::TimePoint now) {
  for (Late& late : late_) {
    if (late.used && now >= late.when && queue_.size() + late.size <= kBufferBytes) {
      enqueue(std::span(late.bytes).first(late.size));
      late.used = false;
    }
  }
  std::size_t count = queue_.size();
  if (bytes_per_s_ > 0.0) {
    count = std::min(count, out_.allow(now, bytes_per_s_, queue_.empty()));
  }
  if (count == 0) {
    return;
  }
  const core::Expected<std::size_t> taken = uart_.write(std::span(queue_).first(count));
  // A real line does not wait for its receiver: bytes that are not taken are lost.
  const std::size_t gone = bytes_per_s_ > 0.0 || !taken ? count : *taken;
  queue_.erase(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(gone));
  out_.allowance -= static_cast<double>(gone);
}

std::span<const std::byte> N1Line::read(core::TimePoint now) {
  std::size_t count = received_.size();
  if (bytes_per_s_ > 0.0) {
    count = std::min(count, in_.allow(now, bytes_per_s_, false));
  }
  if (count == 0) {
    return {};
  }
  const core::Expected<std::size_t> got = uart_.read(std::span(received_).first(count));
  const std::size_t size = got ? *got : 0;
  if (bytes_per_s_ > 0.0) {
    in_.allowance = size < count ? 0.0 : in_.allowance - static_cast<double>(size);
  }
  return std::span(received_).first(size);
}

void N1Line::clear() {
  queue_.clear();
  for (Late& late : late_) {
    late.used = false;
  }
}

}  // namespace m100::sim
