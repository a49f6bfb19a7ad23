// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <functional>
#include <future>
#include <vector>

namespace m100::lab {

/// Calls work(0) to work(count - 1), each once, on as many threads as the program has cores. An exception of `work` is
/// thrown here, after all threads have ended.
inline void on_all_cores(std::size_t count, const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next = 0;
  const auto run = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      work(i);
    }
  };
  cpu_set_t cores;
  const int threads = sched_getaffinity(0, sizeof cores, &cores) == 0 ? CPU_COUNT(&cores) : 1;
  std::vector<std::future<void>> others;
  for (std::size_t k = 1; k < std::min(static_cast<std::size_t>(threads), count); ++k) {
    others.push_back(std::async(std::launch::async, run));
  }
  run();
  for (std::future<void>& other : others) {
    other.get();
  }
}

}  // namespace m100::lab
