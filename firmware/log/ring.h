// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/assert.h"

namespace m100::log {

/// Passes the bytes of messages from the tick to the thread that writes them to the medium. The tick never waits: a
/// message that does not fit is dropped as a whole and counted, so that the log stays readable. One writer, one reader.
class Ring {
 public:
  /// @param storage its size is a power of two; it belongs to the caller and must outlive the ring.
  explicit Ring(std::span<std::byte> storage) : storage_(storage) {
    M100_ASSERT(!storage.empty() && (storage.size() & (storage.size() - 1)) == 0);
  }
  Ring(const Ring&) = delete;
  Ring& operator=(const Ring&) = delete;

  /// Writer only. Takes both parts or neither. @returns false, and counts one message, if there is no room.
  bool push(std::span<const std::byte> head, std::span<const std::byte> body) {
    const std::size_t at = head_.load(std::memory_order_relaxed);  // only the writer changes head_
    const std::size_t tail = tail_.load(std::memory_order_acquire);
    if (storage_.size() - (at - tail) < head.size() + body.size()) {
      dropped_.store(dropped_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
      return false;
    }
    copy_in(at, head);
    copy_in(at + head.size(), body);
    head_.store(at + head.size() + body.size(), std::memory_order_release);  // publishes the bytes copied above
    return true;
  }

  /// Reader only. The oldest bytes, up to the end of the storage; empty when there are none. They stay until pop().
  std::span<const std::byte> front() const {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);  // only the reader changes tail_
    const std::size_t waiting = head_.load(std::memory_order_acquire) - tail;
    const std::size_t offset = tail & (storage_.size() - 1);
    const std::size_t to_end = storage_.size() - offset;
    return storage_.subspan(offset, waiting < to_end ? waiting : to_end);
  }
  /// Reader only. Gives room back. Requires count <= front().size().
  void pop(std::size_t count) {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);  // only the reader changes tail_
    M100_ASSERT(count <= head_.load(std::memory_order_acquire) - tail);
    tail_.store(tail + count, std::memory_order_release);
  }

  /// Reader only. Hands on all bytes in pieces, and gives their room back.
  template <typename Take>
  void drain(Take&& take) {
    for (std::span<const std::byte> piece = front(); !piece.empty(); piece = front()) {
      take(piece);
      pop(piece.size());
    }
  }

  /// Messages dropped since the start; wraps.
  std::uint32_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

 private:
  void copy_in(std::size_t at, std::span<const std::byte> bytes) {
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      storage_[(at + i) & (storage_.size() - 1)] = bytes[i];
    }
  }

  std::span<std::byte> storage_;
  std::atomic<std::size_t> head_{0};
  std::atomic<std::size_t> tail_{0};
  std::atomic<std::uint32_t> dropped_{0};
};

}  // namespace m100::log
