// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "firmware/core/time.h"
#include "hal/uart.h"
#include "host_tests/sim/world/random.h"
#include "protocol/dji/catalogue.h"

namespace m100::sim {

/// The emulated autopilot's end of the cable: frames leave one after the other at the line's rate. A script can make
/// frames be lost, duplicated, delayed or disturbed by noise. Allocates in the constructor only.
class N1Line {
 public:
  /// Size of the autopilot's own transmit buffer; a frame that does not fit is not sent.
  static constexpr std::size_t kBufferBytes = 2048;
  static constexpr std::size_t kLateFrames = 8;
  static constexpr std::size_t kFrameBytes = 256;

  /// @param baud rate to pace both directions to; 0: no pacing, or the UART paces itself (as the mock does).
  N1Line(hal::Uart& uart, std::uint32_t baud, std::uint64_t seed);

  /// Share of frames lost, each way, from now on.
  void set_loss(double share) { loss_ = share; }
  bool loses_incoming() { return loss_ > 0.0 && random_.uniform() < loss_; }

  /// Queues a frame to leave now. @returns false: lost, by the script or because the buffer is full.
  bool send(std::span<const std::byte> frame, core::TimePoint now);
  /// Queues a message without a request, in session 0.
  void push(protocol::MessageId id, std::span<const std::byte> value, core::TimePoint now);
  /// Queues a frame to leave later.
  void send_later(std::span<const std::byte> frame, core::TimePoint when);
  /// Puts noise on the line towards the client.
  void make_noise(std::size_t bytes);

  /// Writes what the line rate allows by now.
  void pump(core::TimePoint now);
  /// Reads what the line rate allows by now.
  std::span<const std::byte> read(core::TimePoint now);
  /// Discards the bytes that have not left.
  void clear();

 private:
  struct Late {
    bool used = false;
    core::TimePoint when{};
    std::size_t size = 0;
    std::array<std::byte, kFrameBytes> bytes{};
  };
  /// The bytes that a line of this rate can carry since the last call; an idle line saves up one byte time only.
  struct Meter {
    core::TimePoint last{};
    double allowance = 0.0;
    std::size_t allow(core::TimePoint now, double bytes_per_s, bool idle);
  };
  void enqueue(std::span<const std::byte> bytes);

  hal::Uart& uart_;
  double bytes_per_s_;
  double loss_ = 0.0;
  Random random_;
  std::vector<std::byte> queue_;
  std::vector<std::byte> received_;
  std::array<Late, kLateFrames> late_{};
  Meter out_;
  Meter in_;
  std::uint16_t push_sequence_ = 0;
};

}  // namespace m100::sim
