// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <thread>

namespace m100::scenario {

/// Time for which each runnable thread of this process, and of the processes that it started, had to wait.
class RunDelays {
 public:
  using Waited_s = std::map<long, double>;  ///< by thread id
  static constexpr long kDisk = 0;          ///< key for waits for a disk; no thread has this id

  /// As Linux counts it (the second number of /proc/ID/task/ID/schedstat); empty if it does not.
  static Waited_s now() {
    const std::map<long, long> parent = parents();
    Waited_s waited;
    add_disk(waited);
    for (const auto& [process, unused] : parent) {
      if (descends_from_us(process, parent)) {
        add_threads(process, waited);
      }
    }
    return waited;
  }
  /// The longest wait of a thread between `before` and `after`; a new thread counts from its beginning.
  static double longest_s(const Waited_s& before, const Waited_s& after) {
    double longest = 0.0;
    for (const auto& [thread, waited] : after) {
      const auto old = before.find(thread);
      longest = std::max(longest, waited - (old == before.end() ? 0.0 : old->second));
    }
    return longest;
  }

  /// What can be read of a file of /proc, up to where reading fails.
  static std::string text(const std::filesystem::path& path) {
    std::ifstream file(path);
    std::string out;
    // A process may end between opening and reading: read() then gives less, where an iterator over the file throws.
    for (std::array<char, 4096> part; file.read(part.data(), part.size()) || file.gcount() > 0;) {
      out.append(part.data(), static_cast<std::size_t>(file.gcount()));
    }
    return out;
  }

 private:
  /// Adds the time for which any task of this machine waited for a disk (/proc/pressure/io, in microseconds). The
  /// counts of runnable threads do not include such a wait. Adds nothing if the kernel does not count it.
  static void add_disk(Waited_s& waited) {
    const std::string pressure = text("/proc/pressure/io");
    const std::size_t total = pressure.find("total=");  // of the first line: at least one task waited
    if (total != std::string::npos) {
      waited[kDisk] = 1e-6 * std::strtod(pressure.c_str() + total + 6, nullptr);
    }
  }
  static std::map<long, long> parents() {
    std::map<long, long> found;
    std::error_code ended;
    for (std::filesystem::directory_iterator entry("/proc", ended), none; !ended && entry != none;
         entry.increment(ended)) {
      const long id = std::atol(entry->path().filename().c_str());
      const std::string stat = id > 0 ? text(entry->path() / "stat") : std::string();
      const std::size_t name_ends = stat.rfind(')');  // followed by the state, a letter, and the parent's id
      if (name_ends != std::string::npos && name_ends + 4 < stat.size()) {
        found[id] = std::atol(stat.c_str() + name_ends + 4);
      }
    }
    return found;
  }
  static bool descends_from_us(long process, const std::map<long, long>& parent) {
    for (auto at = parent.find(process); at != parent.end(); at = parent.find(at->second)) {
      if (at->first == getpid()) {
        return true;
      }
    }
    return false;
  }
  static void add_threads(long process, Waited_s& waited) {
    std::error_code ended;  // a process may end during the visit
    for (std::filesystem::directory_iterator task("/proc/" + std::to_string(process) + "/task", ended), none;
         !ended && task != none; task.increment(ended)) {
      std::istringstream numbers(text(task->path() / "schedstat"));
      double ran_ns = 0.0, waited_ns = 0.0;
      if (numbers >> ran_ns >> waited_ns) {
        waited[std::atol(task->path().filename().c_str())] = 1e-9 * waited_ns;
      }
    }
  }
};

/// Measures how long the machine keeps runnable processes waiting, which delays the programs by that time. Watches its
/// own thread, which notices a stall of the whole machine, and the threads of all programs, one of which may wait while
/// others run.
class StallMeter {
 public:
  /// Ends the measurement. @returns the longest wait of this thread, or of a program's thread within kWindow.
  double longest_s() {
    if (thread_.joinable()) {
      thread_.request_stop();
      thread_.join();
    }
    return longest_s_;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kLook{5};
  static constexpr std::chrono::milliseconds kCount{100};  ///< short: the counts of a program are lost when it ends
  static constexpr std::size_t kWindow = 5;                ///< counts: telemetry is dead after 0.5 s (safety::Limits)

  void look(const std::stop_token& stop) {
    std::deque<RunDelays::Waited_s> counts{RunDelays::now()};
    Clock::time_point last = Clock::now(), counted = last;
    while (!stop.stop_requested()) {
      std::this_thread::sleep_for(kLook);
      const Clock::time_point now = Clock::now();
      note(std::chrono::duration<double>(now - last - kLook).count());
      last = now;
      if (now - counted >= kCount) {
        count(counts);
        counted = last = Clock::now();
      }
    }
    count(counts);
  }
  void count(std::deque<RunDelays::Waited_s>& counts) {
    counts.push_back(RunDelays::now());
    note(RunDelays::longest_s(counts.front(), counts.back()));
    if (counts.size() > kWindow) {
      counts.pop_front();
    }
  }
  void note(double waited_s) { longest_s_ = std::max(longest_s_, waited_s); }

  double longest_s_ = 0.0;  ///< written by the thread until it ends
  std::jthread thread_{[this](const std::stop_token& stop) { look(stop); }};
};

/// Telemetry is dead after 0.5 s (safety::Limits), and four processes take part in a test one after the other:
/// autopilot, program, backup process and the test itself. If the machine keeps each waiting for a quarter of that
/// time, the flight may end rightly.
constexpr double kStall_s = 0.5 / 4.0;
constexpr int kAttempts = 5;

/// Judges programs in real time. A failure on a machine that stalled says nothing about the programs: it counts only if
/// no wait reached kStall_s; otherwise `begin_again` clears up and `flight` is repeated. If the machine stalled in all
/// attempts, the test is skipped with a message. The same promises are also tested in simulated time
/// (scenario.authority).
template <typename Meter = StallMeter>
void judge_in_real_time(const std::function<void()>& begin_again, const std::function<void()>& flight) {
  double stalled_s = 0.0;
  for (int attempt = 1; attempt <= kAttempts; ++attempt) {
    ::testing::TestPartResultArray seen;
    {
      Meter machine;
      const ::testing::ScopedFakeTestPartResultReporter held(
          ::testing::ScopedFakeTestPartResultReporter::INTERCEPT_ALL_THREADS, &seen);
      flight();
      stalled_s = machine.longest_s();
    }
    bool failed = false;
    for (int i = 0; i < seen.size(); ++i) {
      const ::testing::TestPartResult& result = seen.GetTestPartResult(i);
      failed = failed || result.failed();
      if (result.failed() && stalled_s < kStall_s) {
        ADD_FAILURE_AT(result.file_name(), result.line_number()) << result.message();
      }
    }
    if (!failed || stalled_s < kStall_s) {
      return;
    }
    begin_again();
  }
  GTEST_SKIP() << "the machine stalled in each of " << kAttempts << " attempts, in the last for " << stalled_s << " s";
}

}  // namespace m100::scenario
