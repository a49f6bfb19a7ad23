// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <thread>

namespace m100::scenario {

/// How long each thread of this process, and of those that it started, has been kept waiting while it wanted to run.
class RunDelays {
 public:
  using Waited_s = std::map<long, double>;  ///< by the thread's id

  /// As Linux counts it (the second number of /proc/ID/task/ID/schedstat); nothing where it does not.
  static Waited_s now() {
    const std::map<long, long> parent = parents();
    Waited_s waited;
    for (const auto& [process, unused] : parent) {
      if (descends_from_us(process, parent)) {
        add_threads(process, waited);
      }
    }
    return waited;
  }
  /// The longest that a thread waited from `before` to `after`; one that is new waited since its beginning.
  static double longest_s(const Waited_s& before, const Waited_s& after) {
    double longest = 0.0;
    for (const auto& [thread, waited] : after) {
      const auto old = before.find(thread);
      longest = std::max(longest, waited - (old == before.end() ? 0.0 : old->second));
    }
    return longest;
  }

 private:
  static std::string text(const std::filesystem::path& path) {
    std::ifstream file(path);
    return std::string(std::istreambuf_iterator<char>(file), {});
  }
  static std::map<long, long> parents() {
    std::map<long, long> found;
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
      const long id = std::atol(entry.path().filename().c_str());
      const std::string stat = id > 0 ? text(entry.path() / "stat") : std::string();
      const std::size_t name_ends = stat.rfind(')');  // then come the state, a letter, and the parent's id
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
    std::error_code ended;  // a process may end while it is looked at
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

/// How long the machine keeps a process waiting that wants to run: the programs' times are late by that. Looks at its
/// own thread, which sees the machine stand still, and at the threads of all programs, one of which may wait while
/// others run.
class StallMeter {
 public:
  /// The longest wait of this thread, or of a program's within kWindow. Ends the looking.
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
  static constexpr std::chrono::milliseconds kCount{
      100};                                  ///< between two counts: a program that ends takes its waits along
  static constexpr std::size_t kWindow = 5;  ///< counts: telemetry is dead after 0.5 s (safety::Limits)

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

  double longest_s_ = 0.0;  ///< the thread's until it ended
  std::jthread thread_{[this](const std::stop_token& stop) { look(stop); }};
};

}  // namespace m100::scenario
