// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "hal/linux/file_storage.h"
#include "hal/linux/monotonic_clock.h"

namespace m100::hal {
namespace {

using std::chrono::milliseconds;

TEST(MonotonicClock, StartsAtZeroAndSleepsToAbsoluteTimes) {
  MonotonicClock clock;
  EXPECT_LT(clock.now().time_since_epoch(), milliseconds(50));
  const core::TimePoint deadline = clock.now() + milliseconds(20);
  clock.sleep_until(deadline);
  EXPECT_GE(clock.now(), deadline);
  const core::TimePoint before = clock.now();
  clock.sleep_until(deadline);  // passed: returns at once
  clock.sleep_until(core::TimePoint{milliseconds(-1000000000)});
  EXPECT_LT(clock.now() - before, milliseconds(50));
}

// Catches a sleep of relative length: a hundred ticks of 1 ms with work in between would end late.
TEST(MonotonicClock, LatenessDoesNotAddUp) {
  MonotonicClock clock;
  const core::TimePoint start = clock.now();
  for (int i = 1; i <= 100; ++i) {
    clock.sleep_until(start + milliseconds(i));
    const core::TimePoint busy_until = clock.now() + std::chrono::microseconds(300);
    while (clock.now() < busy_until) {
    }
  }
  EXPECT_LT(clock.now() - start, milliseconds(125)) << "130 ms and more if each tick began after the last";
}

struct FileStorageTest : ::testing::Test {
  std::filesystem::path path = std::filesystem::temp_directory_path() / ("m100_log_" + std::to_string(getpid()));
  void SetUp() override { std::filesystem::remove(path); }
  void TearDown() override { std::filesystem::remove(path); }
};

TEST_F(FileStorageTest, AppendsAndRefusesToOverwriteAFlight) {
  const std::string text = "flight";
  {
    FileStorage storage(path.string());
    EXPECT_EQ(storage.append(std::as_bytes(std::span(text))).status(), core::Status::kUnavailable);
    ASSERT_EQ(storage.open(), core::Status::kOk);
    EXPECT_EQ(storage.append(std::as_bytes(std::span(text))).value(), text.size());
    EXPECT_EQ(storage.append(std::as_bytes(std::span(text))).value(), text.size());
    EXPECT_EQ(storage.sync(), core::Status::kOk);
  }
  std::ifstream file(path);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "flightflight");
  FileStorage again(path.string());
  EXPECT_EQ(again.open(), core::Status::kRefused);
}

TEST_F(FileStorageTest, AFullDiskIsReportedAsFull) {
  static constexpr SystemCalls kFull{&::read, [](int, const void*, std::size_t) -> ssize_t {
                                       errno = ENOSPC;
                                       return -1;
                                     }};
  FileStorage storage(path.string(), kFull);
  ASSERT_EQ(storage.open(), core::Status::kOk);
  EXPECT_EQ(storage.append(std::as_bytes(std::span("x"))).status(), core::Status::kResourceExhausted);
}

}  // namespace
}  // namespace m100::hal
