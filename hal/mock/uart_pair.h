// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "hal/clock.h"
#include "hal/uart.h"

namespace m100::hal {

/// Faults that a line applies to the bytes written while they are in force. Probabilities in [0, 1]. "Write" is one
/// call of write(): senders here write one frame per call, so these are faults of whole frames.
struct LineFaults {
  double drop_per_byte = 0.0;
  double flip_per_bit = 0.0;
  double framing_error_per_byte = 0.0;  ///< the stop bit is missing: a random byte arrives and is counted as an error
  double parity_error_per_byte = 0.0;   ///< the byte arrives, and the receiver counts an error
  double break_per_write = 0.0;         ///< the line goes low before the write: a zero byte arrives and is counted
  double duplicate_per_byte = 0.0;
  double drop_per_write = 0.0;
  double duplicate_per_write = 0.0;
  double burst_per_write = 0.0;      ///< noise before the write
  std::size_t burst_bytes = 0;       ///< length of a burst of noise
  core::Duration delay{0};           ///< added to the arrival of each byte
  core::Duration chunk{0};           ///< bytes arrive at the next multiple of this, as from an adapter's latency timer
  std::size_t longest_write = 4096;  ///< small: short writes
};

/// One direction of a line. A byte takes ten bit times; it arrives when it is complete, and never before its
/// predecessor. Allocates in the constructor only.
class Line {
 public:
  static constexpr std::size_t kSenderBytes = 4096;    ///< waiting to leave; beyond it a write is short
  static constexpr std::size_t kReceiverBytes = 4096;  ///< arrived and not read; beyond it the newest are lost

  /// @param baud 0: no pacing, bytes arrive at once.
  Line(Clock& clock, std::uint32_t baud, std::uint64_t seed);

  void set_faults(const LineFaults& faults) { faults_ = faults; }
  /// Plugs or unplugs the cable. Unplugged, reads and writes report kUnavailable; bytes on the line are lost.
  void set_plugged(bool plugged) { plugged_ = plugged; }

  core::Expected<std::size_t> write(std::span<const std::byte> source);
  core::Expected<std::size_t> read(std::span<std::byte> destination);

  struct Stats {
    std::uint64_t bytes_written = 0;  ///< taken from the sender
    std::uint64_t bytes_read = 0;
    std::uint64_t bytes_dropped = 0;  ///< by drop faults
    std::uint64_t bits_flipped = 0;
    std::uint64_t bytes_added = 0;  ///< duplicates, noise and breaks
    std::uint64_t overruns = 0;     ///< lost because nobody read
    std::uint64_t writes_dropped = 0;
  };
  const Stats& stats() const { return stats_; }
  /// The errors that the receiver has detected: errors of bytes count when they are sent, overruns when they are lost.
  LineErrors errors() const { return errors_; }

 private:
  struct Travelling {
    core::TimePoint arrival;
    std::byte value;
  };

  void advance_to_now();
  void lose_newest();
  void carry(std::span<const std::byte> source);
  void carry_byte(std::byte value);
  void add_noise(std::size_t count);
  void enqueue(std::byte value, core::Duration delay);
  bool chance(double probability);
  std::uint64_t random();

  Clock& clock_;
  std::int64_t byte_time_ns_;
  std::int64_t line_free_ns_ = 0;  ///< when the last byte has left
  std::uint64_t random_;
  bool plugged_ = true;
  LineFaults faults_;
  std::vector<Travelling> queue_;  ///< ring: first arrived_, then still travelling
  std::size_t head_ = 0;
  std::size_t size_ = 0;
  std::size_t arrived_ = 0;
  Stats stats_;
  LineErrors errors_;
};

/// Two ends of a serial cable, for one thread: bytes written to one end are read at the other.
class UartPair {
 public:
  UartPair(Clock& clock, std::uint32_t baud, std::uint64_t seed = 1);

  Uart& a() { return a_; }
  Uart& b() { return b_; }
  Line& a_to_b() { return a_to_b_; }
  Line& b_to_a() { return b_to_a_; }
  /// Unplugs the cable or plugs it in again.
  void set_plugged(bool plugged) {
    a_to_b_.set_plugged(plugged);
    b_to_a_.set_plugged(plugged);
  }

 private:
  class End final : public Uart {
   public:
    End(Line& out, Line& in) : out_(out), in_(in) {}
    core::Expected<std::size_t> read(std::span<std::byte> destination) override { return in_.read(destination); }
    core::Expected<std::size_t> write(std::span<const std::byte> source) override { return out_.write(source); }
    core::Expected<LineErrors> line_errors() const override { return in_.errors(); }

   private:
    Line& out_;
    Line& in_;
  };

  Line a_to_b_;
  Line b_to_a_;
  End a_;
  End b_;
};

}  // namespace m100::hal
