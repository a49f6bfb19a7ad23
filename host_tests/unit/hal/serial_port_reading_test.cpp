// SPDX-License-Identifier: BSD-3-Clause
// What a port asks of its driver: when it calls read(), and for how much; its settings and its mark.
#include <dlfcn.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "hal/linux/serial_port.h"
#include "host_tests/unit/hal/far_side.h"

// A pseudo-terminal in the place of a device whose driver grants other settings, or that is no pseudo-terminal.
static void (*change_granted)(termios&) = nullptr;
static dev_t pretended_device = 0;
static bool refuses_settings = false;

extern "C" int tcgetattr(int descriptor, termios* settings) noexcept {
  static const auto real = reinterpret_cast<int (*)(int, termios*)>(dlsym(RTLD_NEXT, "tcgetattr"));
  const int result = real(descriptor, settings);
  if (change_granted != nullptr) {
    change_granted(*settings);
  }
  return result;
}
extern "C" int tcsetattr(int descriptor, int when, const termios* settings) noexcept {
  static const auto real = reinterpret_cast<int (*)(int, int, const termios*)>(dlsym(RTLD_NEXT, "tcsetattr"));
  return refuses_settings ? -1 : real(descriptor, when, settings);
}
extern "C" int fstat(int descriptor, struct stat* out) noexcept {
  const int result = fstatat(descriptor, "", out, AT_EMPTY_PATH);
  out->st_rdev = pretended_device != 0 ? pretended_device : out->st_rdev;
  return result;
}

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
  waits = -1;  // a driver's nonsense is nothing
  port.mark_arrived();
  EXPECT_EQ(port.read(destination).value_or(9), 0U);
  port.close();
  ASSERT_EQ(port.open(), core::Status::kOk);
  far.send("gh");
  EXPECT_EQ(port.read(destination).value_or(9), 0U);
  waits = 2;
  EXPECT_EQ(read_some(port, destination).value(), 2U) << "no mark of before";
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
  port.mark_arrived();
  EXPECT_EQ(port.read(destination).status(), core::Status::kUnavailable);
  EXPECT_FALSE(port.is_open());
}

TEST(SerialPort, RefusesADriverThatGrantsOtherSettings) {
  FarSide far;
  const auto open = open_files();
  for (void (*const other)(termios&) : {+[](termios& granted) { cfsetospeed(&granted, B9600); },
                                        +[](termios& granted) { granted.c_cflag &= ~static_cast<tcflag_t>(CSIZE); }}) {
    change_granted = other;
    SerialPort port(far.name(), 230400);
    EXPECT_EQ(port.open(), core::Status::kUnavailable);
    EXPECT_FALSE(port.is_open());
    change_granted = nullptr;
    EXPECT_EQ(open_files(), open);
    EXPECT_EQ(port.open(), core::Status::kOk);
    refuses_settings = true;
    EXPECT_EQ(port.open(), core::Status::kUnavailable);
    refuses_settings = false;
  }
}

// A serial line is marked for exclusive use as long as it is open; a pseudo-terminal, of eight majors, is not.
TEST(SerialPort, MarksADeviceThatForgetsTheMarkWithItsHolder) {
  FarSide far;
  for (const unsigned major_number : {4U, 135U, 136U, 143U, 144U, 188U}) {
    pretended_device = makedev(major_number, 1);
    SerialPort port(far.name(), 230400);
    ASSERT_EQ(port.open(), core::Status::kOk);
    pretended_device = 0;
    int marked = 9;
    EXPECT_EQ(ioctl(port.descriptor(), TIOCGEXCL, &marked), 0);
    EXPECT_EQ(marked != 0, major_number < 136 || major_number > 143) << major_number;
    const int witness = ::dup(port.descriptor());
    port.close();
    EXPECT_EQ(ioctl(witness, TIOCGEXCL, &marked), 0);
    EXPECT_EQ(marked, 0);
    ::close(witness);
  }
}

}  // namespace
}  // namespace m100::hal
