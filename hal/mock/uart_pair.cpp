// SPDX-License-Identifier: BSD-3-Clause
#include "hal/mock/uart_pair.h"

#include <algorithm>

namespace m100::hal {
namespace {

constexpr std::int64_t kBitsPerByte = 10;  // start, eight data, stop
constexpr std::int64_t kNanosPerSecond = 1000000000;
constexpr std::int64_t kNanosPerMicro = 1000;
constexpr std::size_t kQueue = Line::kSenderBytes + Line::kReceiverBytes;

std::int64_t nanos(core::TimePoint time) { return time.time_since_epoch().count() * kNanosPerMicro; }

/// The first whole microsecond that is not before at_ns.
core::TimePoint time_of(std::int64_t at_ns) {
  return core::TimePoint{core::Duration{(at_ns + kNanosPerMicro - 1) / kNanosPerMicro}};
}

}  // namespace

Line::Line(Clock& clock, std::uint32_t baud, std::uint64_t seed)
    : clock_(clock),
      byte_time_ns_(baud == 0 ? 0 : kBitsPerByte * kNanosPerSecond / baud),
      random_(seed * 2 + 1),
      queue_(kQueue) {}

// xorshift64* (Vigna, 2016): small, and the same on every machine.
std::uint64_t Line::random() {
  random_ ^= random_ >> 12U;
  random_ ^= random_ << 25U;
  random_ ^= random_ >> 27U;
  return random_ * 0x2545F4914F6CDD1DULL;
}

bool Line::chance(double probability) {
  return probability > 0.0 && static_cast<double>(random() >> 11U) * 0x1p-53 < probability;
}

void Line::advance_to_now() {
  const core::TimePoint now = clock_.now();
  while (arrived_ < size_ && queue_[(head_ + arrived_) % kQueue].arrival <= now) {
    if (arrived_ < kReceiverBytes) {
      ++arrived_;
      continue;
    }
    // The receiver is full: this byte is lost, and the bytes after it move up.
    for (std::size_t i = arrived_; i + 1 < size_; ++i) {
      queue_[(head_ + i) % kQueue] = queue_[(head_ + i + 1) % kQueue];
    }
    --size_;
    lose_newest();
  }
}

void Line::lose_newest() {
  ++stats_.overruns;
  ++errors_.overrun;
}

void Line::enqueue(std::byte value, core::Duration delay) {
  line_free_ns_ = std::max(line_free_ns_, nanos(clock_.now())) + byte_time_ns_;
  if (size_ == kQueue) {
    lose_newest();
    return;
  }
  core::TimePoint arrival = time_of(line_free_ns_) + delay;
  if (const core::Duration chunk = faults_.chunk; chunk > core::Duration{0}) {
    arrival = core::TimePoint(chunk * ((arrival.time_since_epoch() + chunk - core::Duration{1}) / chunk));
  }
  if (size_ > 0) {
    arrival = std::max(arrival, queue_[(head_ + size_ - 1) % kQueue].arrival);
  }
  queue_[(head_ + size_) % kQueue] = {arrival, value};
  ++size_;
}

void Line::add_noise(std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    enqueue(static_cast<std::byte>(random() >> 56U), core::Duration{0});
  }
  stats_.bytes_added += count;
}

void Line::carry_byte(std::byte value) {
  if (chance(faults_.drop_per_byte)) {
    ++stats_.bytes_dropped;
    line_free_ns_ = std::max(line_free_ns_, nanos(clock_.now())) + byte_time_ns_;
    return;
  }
  if (faults_.flip_per_bit > 0.0) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      if (chance(faults_.flip_per_bit)) {
        value ^= std::byte{1} << bit;
        ++stats_.bits_flipped;
      }
    }
  }
  if (chance(faults_.framing_error_per_byte)) {
    value = static_cast<std::byte>(random() >> 56U);
    ++errors_.framing;
  }
  errors_.parity += chance(faults_.parity_error_per_byte) ? 1U : 0U;
  enqueue(value, faults_.delay);
  if (chance(faults_.duplicate_per_byte)) {
    enqueue(value, faults_.delay);
    ++stats_.bytes_added;
  }
}

void Line::carry(std::span<const std::byte> source) {
  for (const std::byte value : source) {
    carry_byte(value);
  }
}

core::Expected<std::size_t> Line::write(std::span<const std::byte> source) {
  advance_to_now();
  if (!plugged_) {
    size_ = 0;
    arrived_ = 0;
    return core::Status::kUnavailable;
  }
  const std::size_t waiting = std::min(size_ - arrived_, kSenderBytes);
  const std::size_t count = std::min({source.size(), kSenderBytes - waiting, faults_.longest_write});
  const std::span<const std::byte> taken = source.first(count);
  stats_.bytes_written += count;
  if (count == 0) {
    return count;
  }
  if (chance(faults_.drop_per_write)) {
    ++stats_.writes_dropped;
    stats_.bytes_dropped += count;
    return count;
  }
  if (chance(faults_.burst_per_write)) {
    add_noise(faults_.burst_bytes);
  }
  if (chance(faults_.break_per_write)) {
    enqueue(std::byte{0}, faults_.delay);
    ++stats_.bytes_added;
    ++errors_.breaks;
  }
  carry(taken);
  if (chance(faults_.duplicate_per_write)) {
    carry(taken);
    stats_.bytes_added += count;
  }
  return count;
}

core::Expected<std::size_t> Line::read(std::span<std::byte> destination) {
  advance_to_now();
  if (!plugged_) {
    size_ = 0;
    arrived_ = 0;
    return core::Status::kUnavailable;
  }
  const std::size_t count = std::min(destination.size(), arrived_);
  for (std::size_t i = 0; i < count; ++i) {
    destination[i] = queue_[(head_ + i) % kQueue].value;
  }
  head_ = (head_ + count) % kQueue;
  size_ -= count;
  arrived_ -= count;
  stats_.bytes_read += count;
  return count;
}

UartPair::UartPair(Clock& clock, std::uint32_t baud, std::uint64_t seed)
    : a_to_b_(clock, baud, 2 * seed), b_to_a_(clock, baud, 2 * seed + 1), a_(a_to_b_, b_to_a_), b_(b_to_a_, a_to_b_) {}

}  // namespace m100::hal
