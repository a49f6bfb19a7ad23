// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "hal/uart.h"

namespace m100::link {

/// Frames that wait for a UART, which may take them in pieces. Requests and answers wait in a queue of kRequests; there
/// is at most one flight command. Any frame can be dropped at any time, even half written (the receiver discards an
/// incomplete frame). No frame begins before the one before is complete or dropped. No heap.
class Outbox {
 public:
  static constexpr std::size_t kRequests = 8;
  static constexpr std::size_t kFrameBytes = 160;

  /// @returns false: the frame is too long, or the queue is full.
  [[nodiscard]] bool add_request(std::span<const std::byte> frame) { return add(frame, false); }
  /// An answer to the autopilot; it waits in the same queue, and drop_requests() keeps it.
  [[nodiscard]] bool add_answer(std::span<const std::byte> frame) { return add(frame, true); }

  /// @returns false: too long, or the command before is half written.
  [[nodiscard]] bool set_command(std::span<const std::byte> frame) {
    if (frame.size() > kFrameBytes || (command_.size > 0 && command_.written > 0)) {
      return false;
    }
    command_.assign(frame);
    return true;
  }

  bool has_command() const { return command_.size > 0; }
  bool has_requests() const { return count_ > 0; }
  void drop_command() { command_ = {}; }
  /// Drops all requests, also one that is half written, because they are no longer valid. Answers stay.
  void drop_requests() {
    const std::size_t waiting = count_;
    count_ = 0;
    for (std::size_t i = 0; i < waiting; ++i) {
      const Frame& frame = requests_[(first_ + i) % kRequests];
      if (frame.is_answer) {
        requests_[(first_ + count_) % kRequests] = frame;
        ++count_;
      }
    }
  }
  void drop_all() {
    drop_command();
    count_ = 0;
  }

  /// Writes until everything is sent or the UART takes no more.
  /// @param on_sent called with the bytes of each successful write.
  /// @returns kOk, or the status of the UART.
  template <typename OnSent>
  core::Status flush(hal::Uart& uart, OnSent&& on_sent) {
    for (std::size_t frames = 0; frames <= kRequests && (count_ > 0 || has_command()); ++frames) {
      Frame& frame = current();
      const core::Expected<std::size_t> taken = uart.write(frame.rest());
      if (!taken) {
        return taken.status();
      }
      on_sent(frame.rest().first(*taken));
      frame.written += *taken;
      if (frame.written < frame.size) {
        break;
      }
      finish(frame);
    }
    return core::Status::kOk;
  }

 private:
  struct Frame {
    std::array<std::byte, kFrameBytes> bytes{};
    std::size_t size = 0;
    std::size_t written = 0;
    bool is_answer = false;
    void assign(std::span<const std::byte> frame) {
      std::copy(frame.begin(), frame.end(), bytes.begin());
      size = frame.size();
      written = 0;
    }
    std::span<const std::byte> rest() const { return std::span(bytes).subspan(written, size - written); }
  };

  bool add(std::span<const std::byte> frame, bool is_answer) {
    if (count_ == kRequests || frame.size() > kFrameBytes) {
      return false;
    }
    Frame& place = requests_[(first_ + count_) % kRequests];
    place.assign(frame);
    place.is_answer = is_answer;
    ++count_;
    return true;
  }

  /// The frame to write: one that is half written must be finished first; otherwise requests go before the command.
  Frame& current() {
    const bool command_begun = has_command() && command_.written > 0;
    return command_begun || count_ == 0 ? command_ : requests_[first_];
  }
  void finish(const Frame& frame) {
    if (&frame == &command_) {
      drop_command();
    } else {
      first_ = (first_ + 1) % kRequests;
      --count_;
    }
  }

  std::array<Frame, kRequests> requests_{};
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  Frame command_;
};

}  // namespace m100::link
