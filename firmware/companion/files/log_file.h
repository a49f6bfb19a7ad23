// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include "firmware/companion/files/text/printable.h"
#include "firmware/companion/files/text/text_file.h"
#include "firmware/companion/subcommands.h"
#include "firmware/log/flight_log.h"
#include "hal/linux/file_storage.h"

namespace m100::companion {

/// Writes a log to a file from a thread of its own: that thread waits for the medium, the tick never does.
class LogFile {
 public:
  /// @param when_full the end of the line on stderr that says why the medium takes no more data. Errors: UsageError.
  explicit LogFile(const std::string& path, std::string when_full = "the flight goes on without the rest of its log")
      : file_(path), when_full_(std::move(when_full)), storage_(kRingBytes), ring_(storage_), log_(ring_) {
    if (file_.open() != core::Status::kOk) {
      throw UsageError(path + (std::filesystem::exists(path)
                                   ? ": exists already; a log is not overwritten"
                                   : ": cannot be written: " + why_not_written(file_.last_error())));
    }
  }
  ~LogFile() { finish(); }
  LogFile(const LogFile&) = delete;
  LogFile& operator=(const LogFile&) = delete;

  void start() {
    writer_ = std::thread([this] {
      while (running_ || !ring_.front().empty()) {
        if (!drain()) {
          return;  // the medium is full or gone: the ring fills, and the log counts what it drops
        }
        ++rounds_;
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
      }
    });
  }
  /// Writes the rest of the log and waits until it is on the medium. Nothing may be appended afterwards.
  void finish() {
    running_ = false;
    if (writer_.joinable()) {
      writer_.join();
      if (!is_cut_ && file_.sync() != core::Status::kOk) {
        report_cut();
      }
    }
  }
  /// Waits, in the machine's time, until the log so far is in the file. Only for flights in simulated time: they run as
  /// fast as the machine can, and a busy machine writes more slowly than they log.
  void wait_until_written() const {
    for (const std::uint32_t seen = rounds_; running_ && !is_cut_ && rounds_ - seen < 2;) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  log::FlightLogWriter& log() { return log_; }
  log::Ring& ring() { return ring_; }
  /// The medium took no more data: the rest of the log is not in the file.
  bool is_cut() const { return is_cut_; }
  /// One line, for the end of a program whose log is cut.
  std::string why_cut() const {
    return printable(file_.path()) + ": the log is cut short: " + why_not_written(file_.last_error());
  }

 private:
  static constexpr std::size_t kRingBytes = 1U << 20U;

  void report_cut() {
    std::cerr << "m100: " << printable(file_.path()) << ": " << why_not_written(file_.last_error()) << "; "
              << when_full_ << "\n";
    is_cut_ = true;
  }

  bool drain() {
    while (!ring_.front().empty()) {
      const core::Expected<std::size_t> taken = file_.append(ring_.front());
      if (!taken) {
        report_cut();
        return false;
      }
      ring_.pop(*taken);
    }
    return true;
  }

  hal::FileStorage file_;
  std::string when_full_;
  std::vector<std::byte> storage_;
  log::Ring ring_;
  log::FlightLogWriter log_;
  std::atomic<bool> running_{true};
  std::atomic<bool> is_cut_{false};
  std::atomic<std::uint32_t> rounds_{0};  ///< passes of the writer: each writes at least what the ring held before
  std::thread writer_;
};

}  // namespace m100::companion
