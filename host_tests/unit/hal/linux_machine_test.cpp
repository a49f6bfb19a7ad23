// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "hal/linux/file_storage.h"
#include "hal/linux/monotonic_clock.h"
#include "host_tests/own_folder.h"
#include "host_tests/unit/hal/far_side.h"

namespace m100::hal {
namespace {

using std::chrono::milliseconds;

core::Duration raw_time() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::chrono::seconds(now.tv_sec) +
         std::chrono::duration_cast<core::Duration>(std::chrono::nanoseconds(now.tv_nsec));
}

// The order of the readings holds however long the machine stops between two of these lines.
TEST(MonotonicClock, CountsFromItsConstruction) {
  RecordProperty("promise", "R9");
  const core::Duration before = raw_time();
  MonotonicClock clock;
  const core::Duration constructed = raw_time();
  const core::Duration now = clock.now().time_since_epoch();
  const core::Duration after = raw_time();
  EXPECT_GE(now, core::Duration(0));
  EXPECT_LE(now, after - before);
  EXPECT_GE(clock.now().time_since_epoch(), after - constructed);
}

/// One call of the kernel's sleep.
struct Sleep {
  clockid_t clock;
  int flags;
  core::Duration until;
};
std::vector<Sleep> sleeps;
int sleep_interruptions = 0;

int note_sleep(clockid_t clock, int flags, const timespec* until, timespec*) {
  sleeps.push_back({clock, flags,
                    std::chrono::seconds(until->tv_sec) +
                        std::chrono::duration_cast<core::Duration>(std::chrono::nanoseconds(until->tv_nsec))});
  return sleep_interruptions-- > 0 ? EINTR : 0;
}
constexpr SystemCalls kNoted{.sleep = &note_sleep};

// Catches a relative sleep, whose lateness adds up from tick to tick, and a sleep on the wall clock: the kernel must be
// given the deadline itself, whatever the time is.
TEST(MonotonicClock, AsksForAbsoluteDeadlinesSoThatLatenessDoesNotAddUp) {
  RecordProperty("promise", "R9");
  sleeps.clear();
  sleep_interruptions = 0;
  const core::Duration before = raw_time();
  MonotonicClock clock(kNoted);
  for (int i = 0; i < 100; ++i) {
    clock.sleep_until(core::TimePoint{milliseconds(10 * i)});
  }
  ASSERT_EQ(sleeps.size(), 100U);
  for (std::size_t i = 0; i < sleeps.size(); ++i) {
    EXPECT_EQ(sleeps[i].clock, CLOCK_MONOTONIC);
    EXPECT_EQ(sleeps[i].flags, TIMER_ABSTIME);
    EXPECT_EQ(sleeps[i].until - sleeps[0].until, milliseconds(10 * static_cast<int>(i)));
  }
  EXPECT_GE(sleeps[0].until, before) << "time 0 is the construction";
  EXPECT_LE(sleeps[0].until, raw_time());
}

TEST(MonotonicClock, GoesBackToSleepWhenASignalWakesIt) {
  sleeps.clear();
  sleep_interruptions = 3;
  MonotonicClock clock(kNoted);
  clock.sleep_until(core::TimePoint{milliseconds(10)});
  ASSERT_EQ(sleeps.size(), 4U);
  EXPECT_EQ(sleeps[3].until, sleeps[0].until);
}

TEST(MonotonicClock, ReallySleepsAndDoesNotForADeadlineBeforeItsMachineStarted) {
  MonotonicClock clock;
  const core::TimePoint deadline = clock.now() + milliseconds(20);
  clock.sleep_until(deadline);
  EXPECT_GE(clock.now(), deadline);
  sleeps.clear();
  MonotonicClock noted(kNoted);
  noted.sleep_until(core::TimePoint{std::chrono::hours(-1000000)});
  EXPECT_TRUE(sleeps.empty());
}

struct FileStorageTest : host_tests::FolderTest {
  const std::filesystem::path path = folder / "log";
  void SetUp() override {
    FolderTest::SetUp();
    free_descriptor_zero();
  }
};

TEST_F(FileStorageTest, AppendsToAFlight) {
  const std::string text = "flight";
  const auto open = open_files();
  {
    FileStorage storage(path.string());
    EXPECT_EQ(storage.append(std::as_bytes(std::span(text))).status(), core::Status::kUnavailable);
    ASSERT_EQ(storage.open(), core::Status::kOk);
    EXPECT_EQ(storage.open(), core::Status::kOk) << "it is open, not refused as existing";
    EXPECT_EQ(storage.append(std::as_bytes(std::span(text))).value(), text.size());
    EXPECT_EQ(storage.append(std::as_bytes(std::span(text))).value(), text.size());
    EXPECT_EQ(storage.sync(), core::Status::kOk);
  }
  EXPECT_EQ(open_files(), open);
  EXPECT_EQ(std::filesystem::status(path).permissions() & std::filesystem::perms(0755), std::filesystem::perms(0644));
  EXPECT_EQ(host_tests::text_of(path), "flightflight");
}

int error_of_writing = 0;
constexpr SystemCalls kFailing{.write = [](int, const void*, std::size_t) -> ssize_t {
  errno = error_of_writing;
  return -1;
}};

// Catches an error that gets the meaning of another one: a full disk ends the log, a busy one does not.
TEST_F(FileStorageTest, EachErrorOfWritingHasItsMeaning) {
  FileStorage storage(path.string(), kFailing);
  ASSERT_EQ(storage.open(), core::Status::kOk);
  const auto status = [&](int error) {
    error_of_writing = error;
    return storage.append(std::as_bytes(std::span("x"))).status();
  };
  for (const int later : {EINTR, EAGAIN}) {
    EXPECT_EQ(status(later), core::Status::kOk) << later;
    EXPECT_EQ(storage.append(std::as_bytes(std::span("x"))).value_or(9), 0U) << later;
    EXPECT_EQ(storage.last_error(), 0) << "nothing is lost yet";
  }
  for (const int full : {ENOSPC, EDQUOT}) {
    EXPECT_EQ(status(full), core::Status::kResourceExhausted) << full;
    EXPECT_EQ(storage.last_error(), full);
  }
  for (const int broken : {EIO, EBADF, EFBIG}) {
    EXPECT_EQ(status(broken), core::Status::kUnavailable) << broken;
    EXPECT_EQ(storage.last_error(), broken);
  }
}

// The errno of an earlier call stands beside a write that took nothing.
TEST_F(FileStorageTest, AWriteThatTakesNothingIsNoError) {
  static constexpr SystemCalls kNothing{.write = [](int, const void*, std::size_t) -> ssize_t {
    errno = EIO;
    return 0;
  }};
  FileStorage storage(path.string(), kNothing);
  ASSERT_EQ(storage.open(), core::Status::kOk);
  EXPECT_EQ(storage.append(std::as_bytes(std::span("x"))).value_or(9), 0U);
  EXPECT_EQ(storage.last_error(), 0);
}

// Catches a log that is reported as on the disk although the disk refused it.
TEST_F(FileStorageTest, ADiskThatDoesNotTakeTheFileIsReported) {
  FileStorage storage(path.string());
  ASSERT_EQ(storage.open(), core::Status::kOk);
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code gone;
    if (std::filesystem::read_symlink(entry, gone) == path) {
      ASSERT_EQ(::close(std::stoi(entry.path().filename())), 0);
      break;
    }
  }
  EXPECT_EQ(storage.sync(), core::Status::kUnavailable);
  EXPECT_EQ(storage.last_error(), EBADF);
}

TEST_F(FileStorageTest, SaysWhyItCannotBeOpened) {
  EXPECT_EQ(FileStorage("/sys/m100_log").open(), core::Status::kRefused) << "no right, or mounted read-only";
  FileStorage nowhere("/nowhere/at/all");
  EXPECT_EQ(nowhere.open(), core::Status::kUnavailable);
  EXPECT_EQ(nowhere.last_error(), ENOENT);
  EXPECT_EQ(nowhere.sync(), core::Status::kUnavailable);
  EXPECT_EQ(nowhere.last_error(), EBADF);
  made("log", "x");
  FileStorage again(path.string());
  EXPECT_EQ(again.open(), core::Status::kRefused);
  EXPECT_EQ(again.last_error(), EEXIST);
}

}  // namespace
}  // namespace m100::hal
