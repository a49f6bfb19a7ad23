// SPDX-License-Identifier: BSD-3-Clause
// When a port calls read(), and for how much.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "hal/linux/serial_port.h"
#include "host_tests/unit/hal/far_side.h"

namespace m100::hal {
namespace {

int reads = 0;
ssize_t counted_read(int descriptor, void* destination, std::size_t size) {
  ++reads;
  return ::read(descriptor, destination, size);
}
constexpr SystemCalls kCountedReads{.read = &counted_read};

// Catches a port that calls read() on a line where nothing waits: the kernel then waits for one of its workers, which
// has normal priority, and a flight on a busy board stands still as long as that worker gets no processor.
TEST(SerialPort, AnEmptyLineIsNotRead) {
  FarSide far;
  SerialPort port(far.name(), 230400, kCountedReads);
  ASSERT_EQ(port.open(), core::Status::kOk);
  std::array<std::byte, 16> destination;
  reads = 0;
  for (int tick = 0; tick < 100; ++tick) {
    EXPECT_EQ(port.read(destination).value_or(9), 0U);
  }
  EXPECT_EQ(reads, 0);
  far.send("abc");
  EXPECT_EQ(read_some(port, destination).value(), 3U);
  EXPECT_EQ(reads, 1);
}

// Catches a read that asks for more than waits: having copied that, the kernel would wait for its worker again.
TEST(SerialPort, AReadAsksForNoMoreThanWaits) {
  static std::size_t asked = 0;
  static constexpr SystemCalls kAsked{.read = [](int descriptor, void* destination, std::size_t size) {
    asked = size;
    return ::read(descriptor, destination, size);
  }};
  FarSide far;
  SerialPort port(far.name(), 230400, kAsked);
  ASSERT_EQ(port.open(), core::Status::kOk);
  far.send("a");
  std::array<std::byte, 16> destination;
  EXPECT_EQ(read_some(port, destination).value(), 1U);
  EXPECT_EQ(asked, 1U);
  far.send("abcdef");
  EXPECT_EQ(read_some(port, std::span(destination).first(2)).value(), 2U);
  EXPECT_EQ(asked, 2U);
}

// Catches a flight that stands still between the time of its tick and the read: a pose that came meanwhile would seem
// to have come before it was sent, and all later ones too late.
TEST(SerialPort, BytesThatCameAfterTheMarkWaitForTheNext) {
  static int waits = 0;
  static constexpr SystemCalls kWaits{.waiting = [](int, int* bytes) {
    *bytes = waits;
    return 0;
  }};
  FarSide far;
  SerialPort port(far.name(), 230400, kWaits);
  ASSERT_EQ(port.open(), core::Status::kOk);
  far.send("abcdef");
  std::array<std::byte, 4> destination;
  for (const std::size_t marked : {0U, 1U, 5U}) {
    waits = static_cast<int>(marked);
    port.mark_arrived();
    waits = 6;  // more has come
    for (std::size_t left = marked; left > 0; left -= std::min<std::size_t>(left, 4)) {
      EXPECT_EQ(read_some(port, destination).value(), std::min<std::size_t>(left, 4));
    }
    EXPECT_EQ(port.read(destination).value_or(9), 0U);
  }
}

int error_of_the_count = 0;
int failing_count(int, int*) {
  errno = error_of_the_count;
  return -1;
}
constexpr SystemCalls kFailingCount{.waiting = &failing_count};

TEST(SerialPort, ADeviceThatCannotBeCountedIsGoneAndAnInterruptedCountIsNot) {
  FarSide far;
  std::array<std::byte, 4> destination;
  SerialPort port(far.name(), 230400, kFailingCount);
  ASSERT_EQ(port.open(), core::Status::kOk);
  error_of_the_count = EINTR;
  EXPECT_EQ(port.read(destination).value_or(9), 0U);
  EXPECT_TRUE(port.is_open());
  error_of_the_count = EIO;
  EXPECT_EQ(port.read(destination).status(), core::Status::kUnavailable);
  EXPECT_FALSE(port.is_open());
}

}  // namespace
}  // namespace m100::hal
