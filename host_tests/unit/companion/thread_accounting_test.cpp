// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/monitor/thread_accounting.h"

#include <gtest/gtest.h>

#include <sched.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace m100::companion {
namespace {

using namespace std::chrono_literals;

TEST(ThreadAccounting, TheRunQueueTimeIsTheSecondNumberInNanoseconds) {
  EXPECT_EQ(run_queue_time("7000000 123456789 42\n"), 123456us);
  EXPECT_EQ(run_queue_time("7000000"), 0us);
  EXPECT_EQ(run_queue_time(""), 0us);
}

// Catches counts of the process, of another thread, or since the start: two threads share one processor, so each of
// them is ready without running for part of the time, which the clock bounds.
TEST(ThreadAccounting, CountsTheTimeWithoutAProcessorSinceTheLastCall) {
  std::atomic<bool> runs{true};
  const auto on_one_processor = [](auto&& work) {
    return std::thread([work] {
      cpu_set_t first;
      CPU_ZERO(&first);
      CPU_SET(0, &first);
      (void)sched_setaffinity(0, sizeof(first), &first);
      work();
    });
  };
  std::thread rival = on_one_processor([&runs] {
    while (runs) {
    }
  });
  std::thread counted = on_one_processor([&runs] {
    const auto begin = std::chrono::steady_clock::now();
    ThreadAccounting accounting;  // counts from now on: not before `begin`
    core::Duration waited{0};
    while (waited == core::Duration{0}) {  // until the rival has had its turn
      waited = accounting.update().without_processor;
    }
    EXPECT_LE(waited, std::chrono::steady_clock::now() - begin);
    runs = false;
  });
  counted.join();
  rival.join();
}

TEST(ThreadAccounting, TheWordsGiveEveryNumberItsName) {
  EXPECT_EQ(describe(720ms, {.without_processor = 610ms, .disk_faults = 3}).text(),
            "this program stood still for 0.720 s: ready to run but without a processor for 0.610 s, page faults from "
            "the disk: 3");
}

}  // namespace
}  // namespace m100::companion
