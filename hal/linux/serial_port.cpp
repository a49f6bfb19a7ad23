// SPDX-License-Identifier: BSD-3-Clause
#include "hal/linux/serial_port.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

namespace m100::hal {
namespace {

struct Speed {
  std::uint32_t baud;
  speed_t code;
};
constexpr std::array kSpeeds{Speed{115200, B115200}, Speed{230400, B230400}, Speed{460800, B460800},
                             Speed{921600, B921600}};

const Speed* find_speed(std::uint32_t baud) {
  for (const Speed& speed : kSpeeds) {
    if (speed.baud == baud) {
      return &speed;
    }
  }
  return nullptr;
}

/// A call that is interrupted this often in a row is left for the next tick.
constexpr int kInterruptions = 8;

template <typename Call>
ssize_t uninterrupted(const Call& call) {
  ssize_t result = -1;
  for (int attempt = 0; attempt < kInterruptions; ++attempt) {
    result = call();
    if (result >= 0 || errno != EINTR) {
      break;
    }
  }
  return result;
}

/// Whether the device keeps TIOCEXCL after its last holder has closed it. A serial line does not. A pseudo-terminal
/// does while its other side is open: after its holder was killed, only root could open it again.
bool is_escaped_marker(int descriptor) {
  constexpr unsigned kFirstPseudoTerminal = 136;  // Linux, Documentation/admin-guide/devices.txt: 136 to 143
  constexpr unsigned kLastPseudoTerminal = 143;
  struct stat device {};
  return fstat(descriptor, &device) == 0 && major(device.st_rdev) >= kFirstPseudoTerminal &&
         major(device.st_rdev) <= kLastPseudoTerminal;
}

bool means_later(int error) { return error == EAGAIN || error == EINTR; }

}  // namespace

SerialPort::SerialPort(std::string path, std::uint32_t baud, const SystemCalls& calls)
    : path_(std::move(path)), baud_(baud), calls_(&calls), clock_(path_) {}

SerialPort::~SerialPort() { close(); }

core::Status SerialPort::open() {
  close();
  if (find_speed(baud_) == nullptr) {
    return core::Status::kInvalidArgument;
  }
  descriptor_ = is_simulated(path_) ? open_simulated(path_, baud_) : calls_->open(path_.c_str());
  if (descriptor_ < 0) {
    const bool not_ours = errno == EACCES || errno == EPERM || errno == EBUSY;
    return not_ours ? core::Status::kRefused : core::Status::kUnavailable;
  }
  at_opening_ = driver_counts().value_or(LineErrors{});
  if (isatty(descriptor_) == 1 && flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {  // TIOCEXCL does not stop root
    close();
    return core::Status::kRefused;
  }
  if (!is_simulated(path_) && !configure()) {
    close();
    return core::Status::kUnavailable;
  }
  ++openings_;
  return core::Status::kOk;
}

bool SerialPort::configure() {
  termios settings{};
  if (tcgetattr(descriptor_, &settings) != 0) {
    return false;
  }
  cfmakeraw(&settings);
  settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS | PARENB | CSIZE | HUPCL);
  settings.c_cflag |= CS8 | CLOCAL | CREAD;
  settings.c_iflag &= ~static_cast<tcflag_t>(IXON | IXOFF | IXANY);
  settings.c_cc[VMIN] = 0;
  settings.c_cc[VTIME] = 0;
  const speed_t code = find_speed(baud_)->code;
  if (cfsetispeed(&settings, code) != 0 || cfsetospeed(&settings, code) != 0 ||
      tcsetattr(descriptor_, TCSANOW, &settings) != 0) {
    return false;
  }
  // tcsetattr succeeds when it could apply any of the settings (POSIX), so read them back.
  termios granted{};
  if (tcgetattr(descriptor_, &granted) != 0 || cfgetospeed(&granted) != code || (granted.c_cflag & CSIZE) != CS8) {
    return false;
  }
  if (!is_escaped_marker(descriptor_)) {
    ioctl(descriptor_, TIOCEXCL);  // a second program on this port would take half of the telemetry
  }
  tcflush(descriptor_, TCIOFLUSH);
  return true;
}

core::Expected<LineErrors> SerialPort::driver_counts() const {
  serial_icounter_struct counts{};
  if (descriptor_ < 0 || calls_->line_counters(descriptor_, &counts) != 0) {
    return core::Status::kUnavailable;
  }
  const auto unsigned_of = [](int count) { return static_cast<std::uint32_t>(count); };
  return LineErrors{.framing = unsigned_of(counts.frame),
                    .parity = unsigned_of(counts.parity),
                    .overrun = unsigned_of(counts.overrun) + unsigned_of(counts.buf_overrun),
                    .breaks = unsigned_of(counts.brk)};
}

core::Expected<LineErrors> SerialPort::line_errors() const {
  const core::Expected<LineErrors> now = driver_counts();
  if (!now) {
    return now.status();
  }
  return LineErrors{.framing = before_.framing + now->framing - at_opening_.framing,
                    .parity = before_.parity + now->parity - at_opening_.parity,
                    .overrun = before_.overrun + now->overrun - at_opening_.overrun,
                    .breaks = before_.breaks + now->breaks - at_opening_.breaks};
}

void SerialPort::close() {
  if (descriptor_ >= 0) {
    before_ = line_errors().value_or(before_);
    ioctl(descriptor_, TIOCNXCL);
    ::close(descriptor_);
    descriptor_ = -1;
    arrived_.reset();
  }
}

bool SerialPort::ensure_open() {
  if (descriptor_ >= 0) {
    return true;
  }
  const core::TimePoint now = clock_.now();
  if (now < next_attempt_) {
    return false;
  }
  next_attempt_ = now + kReopenInterval;
  return open() == core::Status::kOk;
}

void SerialPort::mark_arrived() {
  int waiting = 0;
  const bool counted = is_open() && !is_simulated(path_) && calls_->waiting(descriptor_, &waiting) == 0;
  arrived_ =
      counted ? std::optional(static_cast<std::size_t>(std::max(waiting, 0))) : std::nullopt;  // else read() says why
}

core::Expected<std::size_t> SerialPort::read(std::span<std::byte> destination) {
  // The reader must learn of every loss, because another device may now answer under the same name.
  if (std::exchange(unreported_loss_, false) || !ensure_open()) {
    return core::Status::kUnavailable;
  }
  if (destination.empty()) {
    return std::size_t{0};
  }
  const core::Expected<std::size_t> waiting =
      arrived_ ? std::min(destination.size(), *arrived_) : waiting_bytes(destination.size());
  if (!waiting) {
    close();
    return waiting;
  }
  if (*waiting == 0) {
    return std::size_t{0};
  }
  const ssize_t count = uninterrupted([&] { return calls_->read(descriptor_, destination.data(), *waiting); });
  if (count > 0) {
    if (arrived_) {
      *arrived_ -= static_cast<std::size_t>(count);
    }
    return static_cast<std::size_t>(count);
  }
  // A quiet line reads as 0 (VMIN = 0), and so does a socket whose host has disconnected.
  const bool quiet = count == 0 ? !is_simulated(path_) : means_later(errno);
  if (quiet) {
    return std::size_t{0};
  }
  close();
  return core::Status::kUnavailable;
}

core::Expected<std::size_t> SerialPort::waiting_bytes(std::size_t most) const {
  if (is_simulated(path_)) {
    return most;  // a socket: its read() waits for nobody
  }
  int waiting = 0;
  if (calls_->waiting(descriptor_, &waiting) != 0) {
    return means_later(errno) ? core::Expected<std::size_t>(std::size_t{0}) : core::Status::kUnavailable;
  }
  return std::min(most, static_cast<std::size_t>(std::max(waiting, 0)));
}

core::Expected<std::size_t> SerialPort::write(std::span<const std::byte> source) {
  if (!ensure_open()) {
    return core::Status::kUnavailable;
  }
  if (source.empty()) {
    return std::size_t{0};
  }
  const ssize_t count = uninterrupted([&] { return calls_->write(descriptor_, source.data(), source.size()); });
  if (count >= 0) {
    return static_cast<std::size_t>(count);
  }
  if (means_later(errno)) {
    return std::size_t{0};
  }
  close();
  unreported_loss_ = true;
  return core::Status::kUnavailable;
}

}  // namespace m100::hal
