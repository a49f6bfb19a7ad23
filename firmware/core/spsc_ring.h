// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

namespace m100::core {

/// Queue from one writer (an interrupt, or a reader thread) to one reader (the loop), without locks.
///
/// It holds kCapacity elements, a power of two. Nothing is ever overwritten: an element that does not fit is refused
/// and counted. head_ and tail_ count up and wrap; their difference is the number of elements.
template <typename T, std::size_t kCapacity>
class SpscRing {
  static_assert(kCapacity > 0 && (kCapacity & (kCapacity - 1)) == 0, "a power of two makes wrapping free");
  static_assert(kCapacity <= (std::size_t{1} << 31U));

 public:
  /// Writer only. @returns false, and counts one, when the ring is full.
  bool push(const T& value) {
    const std::uint32_t head = head_.load(std::memory_order_relaxed);  // only the writer changes head_
    const std::uint32_t tail = tail_.load(std::memory_order_acquire);  // the reader is done with slots before tail_
    if (head - tail == kCapacity) {
      dropped_.store(dropped_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
      return false;
    }
    slots_[head & kMask] = value;
    head_.store(head + 1, std::memory_order_release);  // publishes the slot written above
    return true;
  }

  /// Reader only. @returns false when the ring is empty; value is untouched then.
  bool pop(T& value) {
    const std::uint32_t tail = tail_.load(std::memory_order_relaxed);  // only the reader changes tail_
    const std::uint32_t head = head_.load(std::memory_order_acquire);  // makes the writer's slot visible
    if (head == tail) {
      return false;
    }
    value = slots_[tail & kMask];
    tail_.store(tail + 1, std::memory_order_release);  // hands the slot back
    return true;
  }

  /// Reader only. Pops as many as there are and fit, in at most two pieces. @returns the filled part of destination.
  std::span<T> pop_into(std::span<T> destination) {
    const std::uint32_t tail = tail_.load(std::memory_order_relaxed);  // only the reader changes tail_
    const std::uint32_t head = head_.load(std::memory_order_acquire);  // makes the writer's slots visible
    const std::size_t count = std::min<std::size_t>(head - tail, destination.size());
    const std::size_t first = std::min<std::size_t>(count, kCapacity - (tail & kMask));
    std::copy_n(slots_.begin() + (tail & kMask), first, destination.begin());
    std::copy_n(slots_.begin(), count - first, destination.begin() + static_cast<std::ptrdiff_t>(first));
    tail_.store(tail + static_cast<std::uint32_t>(count), std::memory_order_release);  // hands the slots back
    return destination.first(count);
  }

  std::size_t size() const { return head_.load(std::memory_order_acquire) - tail_.load(std::memory_order_acquire); }
  static constexpr std::size_t capacity() { return kCapacity; }
  /// Elements refused since the start; wraps.
  std::uint32_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::uint32_t kMask = static_cast<std::uint32_t>(kCapacity - 1);
  std::array<T, kCapacity> slots_{};
  std::atomic<std::uint32_t> head_{0};
  std::atomic<std::uint32_t> tail_{0};
  std::atomic<std::uint32_t> dropped_{0};
};

}  // namespace m100::core
