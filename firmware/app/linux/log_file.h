// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include "firmware/app/linux/subcommands.h"
#include "firmware/log/flight_log.h"
#include "hal/linux/file_storage.h"

namespace m100::app {

/// The flight log on its way to a file: a thread of its own waits for the medium, the tick never does.
class LogFile {
 public:
  explicit LogFile(const std::string& path) : file_(path), storage_(kRingBytes), ring_(storage_), log_(ring_) {
    if (file_.open() != core::Status::kOk) {
      throw UsageError(path + (std::filesystem::exists(path) ? ": exists already; a log is not overwritten"
                                                             : ": cannot be written"));
    }
  }
  ~LogFile() {
    running_ = false;
    if (writer_.joinable()) {
      writer_.join();
    }
    (void)file_.sync();
  }
  LogFile(const LogFile&) = delete;
  LogFile& operator=(const LogFile&) = delete;

  void start() {
    writer_ = std::thread([this] {
      while (running_ || !ring_.front().empty()) {
        if (!drain()) {
          return;  // the medium is full or gone: the ring fills, and the log counts what it drops
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
      }
    });
  }
  log::FlightLog& log() { return log_; }

 private:
  static constexpr std::size_t kRingBytes = 1U << 20U;

  bool drain() {
    while (!ring_.front().empty()) {
      const core::Expected<std::size_t> taken = file_.append(ring_.front());
      if (!taken) {
        std::cerr << "m100: " << file_.path() << ": " << core::name(taken.status())
                  << "; the flight goes on without its log\n";
        return false;
      }
      ring_.pop(*taken);
    }
    return true;
  }

  hal::FileStorage file_;
  std::vector<std::byte> storage_;
  log::Ring ring_;
  log::FlightLog log_;
  std::atomic<bool> running_{true};
  std::thread writer_;
};

}  // namespace m100::app
