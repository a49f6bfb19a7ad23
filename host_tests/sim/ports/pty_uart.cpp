// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/ports/pty_uart.h"

#include <fcntl.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "hal/mock/wrong_baud.h"

namespace m100::sim {
namespace {

struct Speed {
  std::uint32_t baud;
  speed_t code;
};
constexpr std::array kSpeeds{Speed{9600, B9600},     Speed{19200, B19200},   Speed{38400, B38400},
                             Speed{57600, B57600},   Speed{115200, B115200}, Speed{230400, B230400},
                             Speed{460800, B460800}, Speed{921600, B921600}};

/// Whether a running program of this name keeps the pseudo-terminal at the link.
bool is_served(const std::string& link) {
  std::error_code error;
  const std::filesystem::path device = std::filesystem::read_symlink(link, error);
  if (device.empty()) {
    return false;  // a file that another program closes meanwhile reads as empty, too
  }
  const auto comm = [](const std::filesystem::path& process) {
    std::string name;
    std::getline(std::ifstream(process / "comm"), name);
    return name;
  };
  const auto holds = [&](const std::filesystem::path& process) {
    std::error_code gone;
    for (std::filesystem::directory_iterator file(process / "fd", gone), end; !gone && file != end;
         file.increment(gone)) {
      std::error_code unread;
      if (std::filesystem::read_symlink(file->path(), unread) == device) {
        return true;
      }
    }
    return false;
  };
  const std::string own = comm("/proc/self");
  for (std::filesystem::directory_iterator process("/proc", error), end; !error && process != end;
       process.increment(error)) {
    const std::string number = process->path().filename().string();
    if (number.find_first_not_of("0123456789") == std::string::npos && number != std::to_string(::getpid()) &&
        comm(process->path()) == own && holds(process->path())) {
      return true;
    }
  }
  return false;
}

[[noreturn]] void fail(const std::string& name) { throw std::runtime_error(name + ": " + std::strerror(errno)); }

}  // namespace

PtyUart::PtyUart(std::string link, std::uint32_t baud) : link_(std::move(link)), baud_(baud) {
  if (is_served(link_)) {
    throw std::runtime_error(link_ + ": another program like this one serves it; end it, or give another name");
  }
  master_ = hal::Descriptor(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (master_.number < 0 || grantpt(master_.number) != 0 || unlockpt(master_.number) != 0) {
    fail("pseudo-terminal");
  }
  const std::string name = ptsname(master_.number);
  slave_ = hal::Descriptor(::open(name.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  termios settings{};
  if (slave_.number < 0 || tcgetattr(slave_.number, &settings) != 0) {
    fail(name);
  }
  cfmakeraw(&settings);
  for (const Speed& speed : kSpeeds) {
    if (speed.baud == baud_) {
      cfsetispeed(&settings, speed.code);
      cfsetospeed(&settings, speed.code);
    }
  }
  if (tcsetattr(slave_.number, TCSANOW, &settings) != 0) {
    fail(name);
  }
  std::error_code error;
  if (std::filesystem::is_symlink(std::filesystem::symlink_status(link_, error))) {
    std::filesystem::remove(link_, error);
  }
  std::filesystem::create_symlink(name, link_, error);
  if (error) {
    throw std::runtime_error(link_ + ": " + error.message());
  }
}

PtyUart::~PtyUart() {
  std::error_code error;
  if (std::filesystem::read_symlink(link_, error) == ptsname(master_.number)) {  // another program may have replaced it
    std::filesystem::remove(link_, error);
  }
}

std::uint32_t PtyUart::clients_baud() const {
  termios settings{};
  if (tcgetattr(slave_.number, &settings) != 0) {
    return 0;
  }
  for (const Speed& speed : kSpeeds) {
    if (speed.code == cfgetospeed(&settings)) {
      return speed.baud;
    }
  }
  return 0;
}

core::Expected<std::size_t> PtyUart::read(std::span<std::byte> destination) {
  const ssize_t count = ::read(master_.number, destination.data(), destination.size());
  if (count <= 0) {
    return std::size_t{0};
  }
  const std::uint32_t clients = clients_baud();
  if (!rates_differ(clients)) {
    return static_cast<std::size_t>(count);
  }
  const std::vector<std::byte> heard =
      hal::received_at(destination.first(static_cast<std::size_t>(count)), clients, baud_);
  const std::size_t kept =
      std::min(heard.size(), destination.size());  // a faster receiver sees more bytes than were sent
  std::copy_n(heard.begin(), kept, destination.begin());
  return kept;
}

core::Expected<std::size_t> PtyUart::write(std::span<const std::byte> source) {
  const std::uint32_t clients = clients_baud();
  if (rates_differ(clients)) {
    const std::vector<std::byte> heard = hal::received_at(source, baud_, clients);
    (void)!::write(master_.number, heard.data(), heard.size());  // re-sampled bytes are lost if they do not fit
    return source.size();
  }
  const ssize_t count = ::write(master_.number, source.data(), source.size());
  return count > 0 ? static_cast<std::size_t>(count) : std::size_t{0};
}

}  // namespace m100::sim
