// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <string_view>
#include <thread>

#include "firmware/companion/operator/terminal.h"
#include "firmware/companion/operator/text_line.h"
#include "firmware/core/spsc_ring.h"

namespace m100::companion {

/// Writes lines to the standard output from a thread of its own, because a disk or a terminal that accepts nothing
/// blocks whoever writes to it. push() neither waits nor allocates. A line that finds no room is lost.
class LineWriter {
 public:
  static constexpr std::size_t kLines = 32;  ///< that wait for the output

  /// The LineWriter that exists; null: none does.
  static LineWriter* current();

  using Write = void (*)(int descriptor, std::string_view text);

  /// Starts the thread. @param write writes a line to a descriptor; it may block. @param patience how long finish()
  /// waits for a blocked output.
  explicit LineWriter(Write write = &write_nonblocking, std::chrono::milliseconds patience = kTerminalTimeout);
  ~LineWriter() { finish(); }
  LineWriter(const LineWriter&) = delete;
  LineWriter& operator=(const LineWriter&) = delete;

  /// Called by one thread only. Text beyond the length of a TextLine is cut off.
  void push(std::string_view line);

  /// Writes the waiting lines and ends the thread. If the output blocks for longer than `patience`, thread and lines
  /// are abandoned.
  void finish();

 private:
  /// Outlives the object if the thread is left behind.
  struct Shared {
    core::SpscRing<TextLine, kLines> lines;
    std::atomic<bool> runs{true};
    std::atomic<bool> ended{false};
  };
  static void write_all(Shared& shared, Write write);

  std::chrono::milliseconds patience_;
  std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

}  // namespace m100::companion
