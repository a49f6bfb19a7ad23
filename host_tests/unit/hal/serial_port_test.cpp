// SPDX-License-Identifier: BSD-3-Clause
#include "hal/linux/serial_port.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <string>
#include <thread>

#include "host_tests/unit/hal/far_side.h"

namespace m100::hal {
namespace {

TEST(SerialPort, IsRawAtTheAskedSpeed) {
  FarSide far;
  for (const auto& [baud, code] :
       {std::pair{115200U, B115200}, {230400U, B230400}, {460800U, B460800}, {921600U, B921600}}) {
    far.change([](termios& settings) {  // as another program may have left it
      settings.c_cflag = (settings.c_cflag | CSTOPB | CRTSCTS | HUPCL) & ~static_cast<tcflag_t>(CLOCAL | CREAD);
      settings.c_iflag |= IXON | IXOFF | IXANY;
      settings.c_cc[VMIN] = 1;
      settings.c_cc[VTIME] = 5;
    });
    SerialPort port(far.name(), baud);
    ASSERT_EQ(port.open(), core::Status::kOk);
    const termios settings = far.settings();
    EXPECT_EQ(cfgetospeed(&settings), code);
    EXPECT_EQ(settings.c_cflag & (CSIZE | CLOCAL | CREAD), static_cast<tcflag_t>(CS8 | CLOCAL | CREAD));
    EXPECT_EQ(settings.c_cflag & (PARENB | CSTOPB | CRTSCTS | HUPCL), 0U);
    EXPECT_EQ(settings.c_lflag & (ICANON | ECHO | ISIG), 0U);
    EXPECT_EQ(settings.c_iflag & (IXON | IXOFF | IXANY | ICRNL | ISTRIP), 0U);
    EXPECT_EQ(settings.c_oflag & OPOST, 0U);
    EXPECT_EQ(settings.c_cc[VMIN], 0) << "a read waits for bytes";
    EXPECT_EQ(settings.c_cc[VTIME], 0) << "a read waits for time to pass";
  }
}

// Catches a port left in cooked mode: carriage returns, control characters and 0xFF would arrive changed.
TEST(SerialPort, AllByteValuesPassBothWaysUnchanged) {
  FarSide far;
  SerialPort port(far.name(), 230400);
  ASSERT_EQ(port.open(), core::Status::kOk);
  std::string all(256, '\0');
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i] = static_cast<char>(i);
  }
  EXPECT_EQ(port.write(bytes_of(all)).value(), all.size());
  EXPECT_EQ(far.receive(all.size()), all);
  far.send(all);
  std::array<std::byte, 300> got;
  std::size_t size = 0;
  while (size < 256) {
    const std::size_t count = read_some(port, std::span(got).subspan(size)).value();
    ASSERT_GT(count, 0U);
    size += count;
  }
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(got.data()), size), all);
}

TEST(SerialPort, AFullLineTakesPartThenNothing) {
  FarSide far;
  SerialPort port(far.name(), 230400);
  const std::string much(1 << 20, 'x');
  std::size_t taken = 0;
  std::size_t last = 1;
  for (int i = 0; i < 100 && last > 0; ++i) {  // the kernel may make room in between
    const core::Expected<std::size_t> count = port.write(bytes_of(much));
    ASSERT_TRUE(count.has_value());
    last = *count;
    taken += last;
  }
  EXPECT_EQ(last, 0U);
  EXPECT_GT(taken, 0U);
  EXPECT_LT(taken, much.size());
}

TEST(SerialPort, WhatWaitedInTheDriverBeforeOpeningIsThrownAway) {
  FarSide far;
  SerialPort port(far.name(), 230400);
  ASSERT_EQ(port.open(), core::Status::kOk);
  port.close();  // the line stays raw, so the driver keeps the old bytes
  const int witness = ::open(far.name().c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
  far.send("old");
  for (int waiting = 0; waiting < 3;) {
    std::this_thread::sleep_for(kPatience);
    ASSERT_EQ(ioctl(witness, FIONREAD, &waiting), 0);
  }
  ::close(witness);
  ASSERT_EQ(port.open(), core::Status::kOk);
  std::array<std::byte, 16> destination;
  EXPECT_EQ(port.read(destination).value(), 0U);
}

TEST(SerialPort, PulledAndPluggedInAgainAsAnotherDeviceItComesBack) {
  const std::filesystem::path name = std::filesystem::temp_directory_path() / "m100_port";
  auto first = std::make_unique<FarSide>();
  std::filesystem::create_symlink(first->name(), name);
  SerialPort port(name.string(), 921600);
  ASSERT_EQ(port.open(), core::Status::kOk);
  std::array<std::byte, 16> destination;
  EXPECT_EQ(port.read(destination).value(), 0U);

  first.reset();
  std::filesystem::remove(name);
  EXPECT_EQ(port.read(destination).status(), core::Status::kUnavailable);
  EXPECT_EQ(port.write(bytes_of("x")).status(), core::Status::kUnavailable);
  EXPECT_FALSE(port.is_open());

  FarSide other;
  std::filesystem::create_symlink(other.name(), name);
  std::this_thread::sleep_for(SerialPort::kReopenInterval);
  EXPECT_EQ(port.write(bytes_of("x")).value(), 1U);
  EXPECT_EQ(port.openings(), 2U);
  other.send("back");
  EXPECT_EQ(read_some(port, destination).value(), 4U);
  std::filesystem::remove(name);
}

int attempts = 0;

int missing_device(const char*) {
  ++attempts;
  errno = ENOENT;
  return -1;
}
constexpr SystemCalls kMissing{.open = &missing_device};

TEST(SerialPort, ReopeningIsNotTriedAtEveryTick) {
  attempts = 0;
  SerialPort port("/dev/ttyUSB0", 230400, kMissing);
  std::array<std::byte, 16> destination;
  const auto before = std::chrono::steady_clock::now();
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(port.read(destination).status(), core::Status::kUnavailable);
  }
  const auto elapsed = std::chrono::steady_clock::now() - before;  // the longer it took, the more attempts are allowed
  EXPECT_EQ(port.openings(), 0U);
  EXPECT_GE(attempts, 1);
  EXPECT_LE(attempts, 1 + elapsed / SerialPort::kReopenInterval);
}

serial_icounter_struct driver{};
int counting_driver(int, serial_icounter_struct* counters) {
  *counters = driver;
  return 0;
}
constexpr SystemCalls kCounting{.line_counters = &counting_driver};

// Catches a port that counts errors from before it was first opened, or forgets those from before it was opened again.
TEST(SerialPort, CountsWhatWentWrongSinceItWasOpenedFirst) {
  FarSide far;
  SerialPort port(far.name(), 230400, kCounting);
  driver = {};
  driver.frame = 1000;
  driver.parity = 300;
  driver.overrun = 20;
  driver.buf_overrun = 7;
  driver.brk = 5000;
  EXPECT_EQ(port.line_errors().status(), core::Status::kUnavailable) << "not open";
  ASSERT_EQ(port.open(), core::Status::kOk);
  EXPECT_EQ(port.line_errors().value(), LineErrors{});
  driver.frame += 5;
  driver.parity += 1;
  driver.overrun += 2;
  driver.buf_overrun += 3;
  driver.brk += 4;
  const LineErrors wanted{.framing = 5, .parity = 1, .overrun = 5, .breaks = 4};
  EXPECT_EQ(port.line_errors().value(), wanted);
  port.close();
  driver = {};  // another device with the same name
  driver.parity = 2;
  driver.brk = 9;
  ASSERT_EQ(port.open(), core::Status::kOk);
  EXPECT_EQ(port.line_errors().value(), wanted);
  driver.frame += 1;
  driver.parity += 10;
  driver.overrun += 20;
  driver.buf_overrun += 30;
  driver.brk += 40;
  const LineErrors both{.framing = 6, .parity = 11, .overrun = 55, .breaks = 44};
  EXPECT_EQ(port.line_errors().value(), both);
}

TEST(SerialPort, ADeviceThatCountsNothingSaysSo) {
  FarSide far;
  SerialPort port(far.name(), 230400);
  ASSERT_EQ(port.open(), core::Status::kOk);
  EXPECT_EQ(port.line_errors().status(), core::Status::kUnavailable) << "a pseudo-terminal has no line";
}

TEST(SerialPort, NamesWhyItCannotBeOpened) {
  EXPECT_EQ(SerialPort("/nonexistent/tty", 230400).open(), core::Status::kUnavailable);
  EXPECT_EQ(SerialPort("/dev/null", 230400).open(), core::Status::kUnavailable) << "not a serial port";
  FarSide far;
  EXPECT_EQ(SerialPort(far.name(), 250000).open(), core::Status::kInvalidArgument);
}

int error_of_opening = 0;
constexpr SystemCalls kNotOpened{.open = [](const char*) {
  errno = error_of_opening;
  return -1;
}};

// Catches a reason that gets the words of another: "another program holds it" sends the operator to look for one.
TEST(SerialPort, TellsAPortThatIsNotOursFromOneThatIsNotThere) {
  SerialPort port("/dev/ttyUSB0", 230400, kNotOpened);
  for (const int error : {EACCES, EPERM, EBUSY}) {
    error_of_opening = error;
    EXPECT_EQ(port.open(), core::Status::kRefused) << error;
  }
  for (const int error : {ENOENT, ENXIO, EIO, ENODEV}) {
    error_of_opening = error;
    EXPECT_EQ(port.open(), core::Status::kUnavailable) << error;
  }
}

// Root passes the kernel's mark for exclusive use, so the lock has to stop it.
TEST(SerialPort, ASecondProgramIsRefusedAndTheFirstOneKeepsThePort) {
  FarSide far;
  SerialPort first(far.name(), 230400);
  ASSERT_EQ(first.open(), core::Status::kOk);
  SerialPort second(far.name(), 230400);
  EXPECT_EQ(second.open(), core::Status::kRefused);
  EXPECT_FALSE(second.is_open());
  EXPECT_EQ(second.descriptor(), -1);
  EXPECT_EQ(second.openings(), 0U);
  EXPECT_EQ(first.write(bytes_of("a")).value(), 1U);
  EXPECT_EQ(first.open(), core::Status::kOk) << "opened again, it is not in its own way";
  first.close();
  EXPECT_EQ(first.descriptor(), -1);
  EXPECT_EQ(second.open(), core::Status::kOk);
  EXPECT_EQ(second.openings(), 1U);
}

TEST(SerialPort, AnEmptyReadOrWriteAsksTheDeviceForNothing) {
  FarSide far;
  SerialPort port(far.name(), 230400);
  EXPECT_EQ(port.read({}).value_or(9), 0U);
  EXPECT_EQ(port.write({}).value_or(9), 0U);
  EXPECT_TRUE(port.is_open()) << "but the port is opened";
}

int interruptions_left = 0;
int error_to_give = 0;

ssize_t interrupted_read(int descriptor, void* destination, std::size_t size) {
  if (interruptions_left > 0) {
    --interruptions_left;
    errno = error_to_give;
    return -1;
  }
  return ::read(descriptor, destination, size);
}
ssize_t interrupted_write(int descriptor, const void* source, std::size_t size) {
  if (interruptions_left > 0) {
    --interruptions_left;
    errno = error_to_give;
    return -1;
  }
  return ::write(descriptor, source, size);
}
int something_waits(int, int* bytes) {
  *bytes = 4;
  return 0;
}
constexpr SystemCalls kInterrupted{.read = &interrupted_read, .write = &interrupted_write, .waiting = &something_waits};

// Catches an exclusive-use mark (TIOCEXCL) that survives a killed program: a service that does not run as root could
// never open its port again.
TEST(SerialPort, AProgramThatDiesLeavesThePseudoTerminalToTheNext) {
  FarSide far;
  const pid_t child = fork();
  if (child == 0) {
    SerialPort port(far.name(), 230400);
    _exit(port.open() == core::Status::kOk ? 0 : 1);  // closes nothing by itself, as after SIGKILL
  }
  int ended = 0;
  ASSERT_EQ(waitpid(child, &ended, 0), child);
  ASSERT_EQ(ended, 0);
  SerialPort next(far.name(), 230400);
  EXPECT_EQ(next.open(), core::Status::kOk);
  int marked = 1;
  EXPECT_EQ(ioctl(next.descriptor(), TIOCGEXCL, &marked), 0);  // root can always open it, so the test reads the mark
  EXPECT_EQ(marked, 0);
}

TEST(SerialPort, AnInterruptedCallIsRepeatedAndNeverForEver) {
  FarSide far;
  SerialPort port(far.name(), 230400, kInterrupted);
  ASSERT_EQ(port.open(), core::Status::kOk);
  error_to_give = EINTR;
  interruptions_left = 3;
  EXPECT_EQ(port.write(bytes_of("ab")).value(), 2U);
  interruptions_left = 1000;
  EXPECT_EQ(port.write(bytes_of("ab")).value(), 0U);
  EXPECT_EQ(1000 - interruptions_left, 8) << "then it is left for the next tick";
  std::array<std::byte, 4> destination;
  EXPECT_EQ(port.read(destination).value(), 0U);
  interruptions_left = 0;
}

int writes = 0;
ssize_t full_after_an_interruption(int, const void*, std::size_t) {
  errno = EINTR;  // set by the first call; a successful call does not reset it
  return ++writes == 1 ? -1 : 0;
}
constexpr SystemCalls kFullAfterAnInterruption{.write = &full_after_an_interruption};

// Would catch a write to a full line that is repeated because of the errno of an earlier call.
TEST(SerialPort, NoRoomIsAnAnswer) {
  FarSide far;
  SerialPort port(far.name(), 230400, kFullAfterAnInterruption);
  ASSERT_EQ(port.open(), core::Status::kOk);
  writes = 0;
  EXPECT_EQ(port.write(bytes_of("ab")).value(), 0U);
  EXPECT_EQ(writes, 2);
}

TEST(SerialPort, AnErrorOfTheDeviceClosesIt) {
  FarSide far;
  std::array<std::byte, 4> destination;
  for (const int error : {EIO, ENXIO, ENODEV, EBADF}) {
    SerialPort port(far.name(), 230400, kInterrupted);
    ASSERT_EQ(port.open(), core::Status::kOk);
    error_to_give = error;
    interruptions_left = 1;
    EXPECT_EQ(port.read(destination).status(), core::Status::kUnavailable);
    EXPECT_FALSE(port.is_open());
    interruptions_left = 0;
  }
}

// Catches a port that is lost during a write and opened again before any read has reported the loss.
TEST(SerialPort, ALossThatAWriteFoundIsReportedToTheNextRead) {
  FarSide far;
  std::array<std::byte, 4> destination;
  SerialPort port(far.name(), 230400, kInterrupted);
  ASSERT_EQ(port.open(), core::Status::kOk);
  error_to_give = EIO;
  interruptions_left = 1;
  EXPECT_EQ(port.write(bytes_of("ab")).status(), core::Status::kUnavailable);
  EXPECT_FALSE(port.is_open());
  interruptions_left = 0;
  EXPECT_EQ(port.read(destination).status(), core::Status::kUnavailable);
  EXPECT_EQ(port.read(destination).value_or(9), 0U) << "once; then it is open again";
}

}  // namespace
}  // namespace m100::hal
