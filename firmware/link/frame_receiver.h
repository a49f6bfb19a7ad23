// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/time.h"
#include "firmware/link/byte_tap.h"
#include "firmware/link/false_header_detector.h"
#include "firmware/link/link_meter.h"
#include "hal/uart.h"
#include "protocol/dji/frame_parser.h"

namespace m100::link {

/// Bytes of a UART to frames, each with the time at which it arrived.
///
/// The arrival of a frame is the time of the read, less the line time of the bytes after it, but not before the
/// previous read. Cost per tick: parsing the bytes that came, at most kBatchesPerTick batches of kBatchBytes. No heap.
class FrameReceiver {
 public:
#ifdef M100_SMALL_MEMORY
  /// The costliest bytes take 96 instructions each on the Cortex-M7: 384 of them leave the worst tick inside its
  /// budget. A line of 230400 baud brings 231 bytes in a tick, so a full ring of the interrupt, 512, is read in four
  /// ticks.
  static constexpr std::size_t kBatchBytes = 384;
  static constexpr std::size_t kBatchesPerTick = 1;
#else
  static constexpr std::size_t kBatchBytes = 65536;  ///< a driver may hold as much after a stall
  static constexpr std::size_t kBatchesPerTick = 16;
#endif

  /// @param tap may be null.
  FrameReceiver(hal::Uart& uart, std::uint32_t baud, ByteTap* tap)
      : uart_(uart), tap_(tap), baud_(baud), false_headers_(baud) {}

  /// Reads what has arrived since the previous call, which was at `last`.
  /// @param port_back called before the first frame of a port that is back.
  /// @param handle called with each frame and the time of its arrival.
  template <typename PortBack, typename Handle>
  void receive(core::TimePoint last, core::TimePoint now, LinkMeter& meter, PortBack&& port_back, Handle&& handle) {
    const auto take = [&](const protocol::FrameView& frame) {
      handle(frame, arrived(frame, last, now));
      dropped_bytes_ = parser_.stats().bytes_dropped;
    };
    behind_ = true;
    for (std::size_t batch = 0; behind_ && batch < kBatchesPerTick; ++batch) {
      const std::span<const std::byte> bytes = read(now, meter);
      if (port_back_) {
        port_back();
      }
      batch_end_ = parser_.stats().bytes + bytes.size();
      parser_.consume(bytes, take);
      while (false_headers_.is_false(parser_, now, meter.adapter_delay())) {
        parser_.abandon_candidate();
        for (auto frame = parser_.poll(); frame; frame = parser_.poll()) {
          take(*frame);
        }
      }
      behind_ = bytes.size() == waiting_.size();
    }
  }

  /// The last receive() may have left bytes unread: its last batch was full.
  bool is_behind() const { return behind_; }
  bool is_port_gone() const { return port_gone_; }
  /// For `handle`: bytes were dropped between the frame before and this one, so it may have waited in the parser.
  bool follows_damage() const { return dropped_bytes_ != parser_.stats().bytes_dropped; }
  const protocol::ParserStats& stats() const { return parser_.stats(); }

 private:
  std::span<const std::byte> read(core::TimePoint now, LinkMeter& meter);
  core::TimePoint arrived(const protocol::FrameView& frame, core::TimePoint last, core::TimePoint now) const;

  hal::Uart& uart_;
  ByteTap* tap_;
  std::uint32_t baud_;
  protocol::FrameParser parser_{protocol::kMaxAutopilotFrameBytes};
  FalseHeaderDetector false_headers_;
  std::array<std::byte, kBatchBytes> waiting_{};
  std::uint64_t batch_end_ = 0;      ///< position in the stream after the last read
  std::uint64_t dropped_bytes_ = 0;  ///< by the parser, when the frame before was found
  bool behind_ = false;
  bool port_gone_ = false;
  bool port_back_ = false;  ///< in the last read
};

}  // namespace m100::link
