// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/authority/stream_fault_injector.h"

#include <algorithm>

#include "hal/mock/wrong_baud.h"
#include "protocol/crc.h"

namespace m100::authority {
namespace {

/// The same answer as a valid frame of another session.
std::vector<std::byte> of_another_session(std::span<const std::byte> answer) {
  constexpr std::size_t kFlags = 3;
  constexpr std::size_t kCrc16 = 10;
  constexpr std::size_t kCrc32Bytes = 4;
  std::vector<std::byte> frame(answer.begin(), answer.end());
  const auto flags = std::to_integer<std::uint8_t>(frame[kFlags]);
  frame[kFlags] = static_cast<std::byte>((flags & 0xE0U) | ((flags + 1U) & 0x1FU));
  const std::uint16_t short_sum = protocol::crc16(std::span(frame).first(kCrc16));
  frame[kCrc16] = static_cast<std::byte>(short_sum & 0xFFU);
  frame[kCrc16 + 1] = static_cast<std::byte>(short_sum >> 8U);
  if (frame.size() > protocol::kHeaderBytes) {
    const std::uint32_t sum = protocol::crc32(std::span(frame).first(frame.size() - kCrc32Bytes));
    for (std::size_t i = 0; i < kCrc32Bytes; ++i) {
      frame[frame.size() - kCrc32Bytes + i] = static_cast<std::byte>(sum >> (8U * i));
    }
  }
  return frame;
}

}  // namespace

void StreamFaultInjector::queue(std::span<const std::byte> bytes, core::TimePoint now) {
  core::TimePoint when = now + plan.delay;
  if (plan.jitter > core::Duration{0}) {
    when += core::Duration{static_cast<std::int64_t>(random_.uniform() * static_cast<double>(plan.jitter.count()))};
  }
  if (plan.bunch > core::Duration{0}) {
    when = core::TimePoint{} + (when.time_since_epoch() / plan.bunch + 1) * plan.bunch;
  }
  if (!pieces_.empty()) {
    when = std::max(when, pieces_.back().when);
  }
  pieces_.push_back({when, {bytes.begin(), bytes.end()}});
}

void StreamFaultInjector::queue_frames(std::span<const std::byte> bytes, core::TimePoint now) {
  parser_.consume(bytes, [&](const protocol::FrameView& frame) {
    const bool is_telemetry = !frame.header.is_ack && frame.header.session == 0;
    if (!is_telemetry) {
      if (frame.header.is_ack && plan.strange_answers) {
        queue(of_another_session(frame.bytes), now);
      }
      queue(frame.bytes, now);
      return;
    }
    if (standing_.empty() || !plan.telemetry_stands_still) {
      standing_.assign(frame.bytes.begin(), frame.bytes.end());
    }
    queue(standing_, now);
    if (plan.telemetry_again_after > core::Duration{0}) {
      again_.push_back({now + plan.telemetry_again_after, standing_});
    }
  });
}

void StreamFaultInjector::queue_fragments(std::span<const std::byte> bytes, core::TimePoint now) {
  constexpr double kLargest = 16.0;
  constexpr double kApart_us = 1000.0;
  while (!bytes.empty()) {
    const auto wanted = 1 + static_cast<std::size_t>(random_.uniform() * kLargest);
    const std::size_t size = std::min(wanted, bytes.size());
    queue(bytes.first(size), now);
    now += core::Duration{static_cast<std::int64_t>(random_.uniform() * kApart_us)};
    bytes = bytes.subspan(size);
  }
}

void StreamFaultInjector::flip_bits(std::span<std::byte> piece) {
  for (std::byte& byte : piece) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      byte ^= random_.uniform() < plan.flip_per_bit ? static_cast<std::byte>(1U << bit) : std::byte{0};
    }
  }
}

void StreamFaultInjector::take(std::span<const std::byte> bytes, core::TimePoint now) {
  const auto happens = [this](double share) { return share > 0.0 && random_.uniform() < share; };
  const std::size_t swallowed = std::min(plan.swallow, bytes.size());
  plan.swallow -= swallowed;
  bytes = bytes.subspan(swallowed);
  if (bytes.empty() || plan.cut || happens(plan.drop)) {
    return;
  }
  if (plan.in_fragments) {
    queue_fragments(bytes, now);
    return;
  }
  if (plan.telemetry_stands_still || plan.strange_answers || plan.telemetry_again_after > core::Duration{0}) {
    queue_frames(bytes, now);
    return;
  }
  std::vector<std::byte> piece(bytes.begin(), bytes.end());
  if (plan.sent_at != plan.received_at) {
    piece = hal::received_at(piece, plan.sent_at, plan.received_at);
  }
  if (plan.flip_per_bit > 0.0) {
    flip_bits(piece);
  }
  if (held_back_.empty() && happens(plan.swapped)) {
    held_back_ = std::move(piece);
    return;
  }
  queue(piece, now);
  if (happens(plan.twice)) {
    queue(piece, now);
  }
  if (!held_back_.empty()) {
    queue(held_back_, now);
    held_back_.clear();
  }
}

std::vector<std::byte> StreamFaultInjector::due(core::TimePoint now) {
  std::vector<std::byte> bytes;
  for (std::deque<Piece>* const waiting : {&pieces_, &again_}) {
    while (!waiting->empty() && waiting->front().when <= now) {
      bytes.insert(bytes.end(), waiting->front().bytes.begin(), waiting->front().bytes.end());
      waiting->pop_front();
    }
  }
  return bytes;
}

std::vector<std::byte> PoseFaultInjector::pass(std::span<const std::byte> bytes, core::TimePoint now) {
  if (!change_) {
    return {bytes.begin(), bytes.end()};
  }
  std::vector<std::byte> passed;
  parser_.consume(bytes, [&](const mavlink::FrameView& frame) {
    if (!mavlink::is<mavlink::AttPosMocap>(frame)) {
      return;
    }
    auto message = mavlink::decode<mavlink::AttPosMocap>(frame);
    if (change_(message, now)) {
      const mavlink::Frame encoded = mavlink::encode(message, frame.from, frame.sequence);
      passed.insert(passed.end(), encoded.bytes().begin(), encoded.bytes().end());
    }
  });
  return passed;
}

std::vector<std::byte> false_header() {
  std::vector<std::byte> header(12, std::byte{0});
  header[0] = std::byte{0xAA};
  header[1] = std::byte{0xFF};  // 1023, the largest value of the field
  header[2] = std::byte{0x03};
  const std::uint16_t crc = protocol::crc16(std::span(header).first(10));
  header[10] = static_cast<std::byte>(crc & 0xFFU);
  header[11] = static_cast<std::byte>(crc >> 8U);
  return header;
}

}  // namespace m100::authority
