// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/pty_uart.h"

#include <fcntl.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <utility>

namespace m100::sim {
namespace {

[[noreturn]] void fail(const std::string& name) { throw std::runtime_error(name + ": " + std::strerror(errno)); }

}  // namespace

PtyUart::PtyUart(std::string link) : link_(std::move(link)) {
  master_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (master_ < 0 || grantpt(master_) != 0 || unlockpt(master_) != 0) {
    fail("pseudo-terminal");
  }
  const std::string name = ptsname(master_);
  slave_ = ::open(name.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  termios settings{};
  if (slave_ < 0 || tcgetattr(slave_, &settings) != 0) {
    fail(name);
  }
  cfmakeraw(&settings);
  if (tcsetattr(slave_, TCSANOW, &settings) != 0) {
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
  if (std::filesystem::read_symlink(link_, error) == ptsname(master_)) {  // not another's that came after us
    std::filesystem::remove(link_, error);
  }
  ::close(slave_);
  ::close(master_);
}

core::Expected<std::size_t> PtyUart::read(std::span<std::byte> destination) {
  const ssize_t count = ::read(master_, destination.data(), destination.size());
  return count > 0 ? static_cast<std::size_t>(count) : std::size_t{0};
}

core::Expected<std::size_t> PtyUart::write(std::span<const std::byte> source) {
  const ssize_t count = ::write(master_, source.data(), source.size());
  return count > 0 ? static_cast<std::size_t>(count) : std::size_t{0};
}

}  // namespace m100::sim
