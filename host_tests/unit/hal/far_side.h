// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <span>
#include <string>
#include <thread>

#include "hal/linux/descriptor.h"
#include "hal/linux/serial_port.h"

namespace m100::hal {

/// Pause between two attempts. The kernel carries bytes through a pseudo-terminal when it has time, so a test repeats
/// an attempt until it succeeds. If it never does, ctest's time limit ends the test.
inline constexpr std::chrono::milliseconds kPatience{1};

/// How many files this process has open.
inline auto open_files() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), std::filesystem::directory_iterator());
}
/// The next file that is opened gets descriptor 0, which is one like any other.
inline void free_descriptor_zero() { ::close(STDIN_FILENO); }
/// The same file with a descriptor that leaves 0 to what is tested.
inline Descriptor not_zero(int descriptor) {
  const Descriptor former(descriptor);
  return Descriptor(fcntl(descriptor, F_DUPFD_CLOEXEC, 10));
}

/// The far side of a pseudo-terminal, whose name can be moved to another one, as udev does with adapters.
class FarSide {
 public:
  FarSide() : descriptor_(not_zero(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK))) {
    free_descriptor_zero();
    EXPECT_EQ(grantpt(descriptor_.number), 0);
    EXPECT_EQ(unlockpt(descriptor_.number), 0);
  }
  std::string name() const { return ptsname(descriptor_.number); }
  void send(const std::string& text) {
    ASSERT_EQ(::write(descriptor_.number, text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  /// Waits until so many bytes have come.
  std::string receive(std::size_t size) {
    std::string all(size, '\0');
    std::size_t got = 0;
    while (got < size) {
      const ssize_t count = ::read(descriptor_.number, all.data() + got, size - got);
      got += count > 0 ? static_cast<std::size_t>(count) : 0U;
      if (count <= 0) {
        std::this_thread::sleep_for(kPatience);
      }
    }
    return all;
  }
  termios settings() const {
    termios result{};
    EXPECT_EQ(tcgetattr(descriptor_.number, &result), 0);
    return result;
  }
  template <typename Change>
  void change(const Change& change) {
    termios changed = settings();
    change(changed);
    EXPECT_EQ(tcsetattr(descriptor_.number, TCSANOW, &changed), 0);
  }

 private:
  Descriptor descriptor_;
};

inline std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

/// Waits until something has come.
inline core::Expected<std::size_t> read_some(SerialPort& port, std::span<std::byte> destination) {
  core::Expected<std::size_t> count = port.read(destination);
  while (count && *count == 0) {
    std::this_thread::sleep_for(kPatience);
    count = port.read(destination);
  }
  return count;
}

}  // namespace m100::hal
