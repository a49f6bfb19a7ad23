// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string_view>
#include <thread>

#include "firmware/app/tick_record.h"
#include "firmware/companion/operator/terminal.h"
#include "firmware/companion/operator/text_line.h"
#include "firmware/core/spsc_ring.h"

namespace m100::companion {

/// Writes lines to the standard output from a thread of its own, because a disk or a terminal that accepts nothing
/// blocks whoever writes to it; below them stands a status line, renewed five times a second, if the operator wants
/// one. push() and show() neither wait nor allocate. What finds no room is lost.
class LineWriter {
 public:
  static constexpr std::size_t kLines = 32;  ///< that wait for the output
  static constexpr std::uint32_t kTicksPerStatus = 20;

  /// The LineWriter that exists; null: none does.
  static LineWriter* current();

  using Write = void (*)(int descriptor, std::string_view text);

  /// Starts the thread. @param write writes a line to a descriptor; it may block. @param patience how long finish()
  /// waits for a blocked output.
  explicit LineWriter(bool has_status = false, Write write = &write_nonblocking,
                      std::chrono::milliseconds patience = kTerminalTimeout);
  ~LineWriter() { finish(); }
  LineWriter(const LineWriter&) = delete;
  LineWriter& operator=(const LineWriter&) = delete;

  /// Called by one thread only. Text beyond the length of a TextLine is cut off.
  void push(std::string_view line);
  /// Called by the same thread after each tick.
  void show(const app::TickRecord<double>& record) {
    if (has_status_ && ticks_++ % kTicksPerStatus == 0) {
      (void)shared_->records.push(record);
    }
  }

  /// Writes the waiting lines, erases the status line and ends the thread. If the output blocks for longer than
  /// `patience`, thread and lines are abandoned.
  void finish();

 private:
  /// Outlives the object if the thread is left behind.
  struct Shared {
    core::SpscRing<TextLine, kLines> lines;
    core::SpscRing<app::TickRecord<double>, 16> records;
    std::array<link::PoseLinkStats, 5> former{};  ///< of the last five status lines, of one second
    std::uint32_t shown = 0;
    std::atomic<bool> runs{true};
    std::atomic<bool> ended{false};
  };
  static void write_all(Shared& shared, Write write);

  bool has_status_;
  std::uint32_t ticks_ = 0;
  std::chrono::milliseconds patience_;
  std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

}  // namespace m100::companion
