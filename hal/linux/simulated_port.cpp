// SPDX-License-Identifier: BSD-3-Clause
#include "hal/linux/simulated_port.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace m100::hal {
namespace {

constexpr std::size_t kPrefix = 4;  // "sim:"

int connect_to(const std::string& port, SimulatedPurpose purpose, std::uint32_t value) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::size_t size = port.size() - kPrefix;
  if (size == 0 || size >= sizeof(address.sun_path)) {
    errno = ENAMETOOLONG;
    return -1;
  }
  std::memcpy(address.sun_path, port.c_str() + kPrefix, size);
  const int descriptor = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) {
    return -1;
  }
  const SimulatedHello hello{purpose, value};
  if (::connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 ||
      ::send(descriptor, &hello, sizeof(hello), MSG_NOSIGNAL) != sizeof(hello)) {
    const int why = errno;
    ::close(descriptor);
    errno = why;
    return -1;
  }
  return descriptor;
}

/// @returns false: the peer has disconnected.
bool receive(int descriptor, void* destination, std::size_t size) {
  ssize_t count = -1;
  do {
    count = ::recv(descriptor, destination, size, MSG_WAITALL);
  } while (count < 0 && errno == EINTR);
  return count == static_cast<ssize_t>(size);
}

/// The connection of this process to the host's time. One per process: two would wait for each other.
struct Attendance {
  int descriptor = -1;
  pid_t process = -1;
  std::int64_t now_us = 0;

  void join(const std::string& host) {
    const pid_t self = ::getpid();
    if (process == self) {
      return;  // also if the host has disconnected: time then continues by itself
    }
    if (descriptor >= 0) {
      ::close(descriptor);  // the parent's; while we hold it, the host does not see the parent end
    }
    process = self;
    descriptor = connect_to(host, SimulatedPurpose::kClock, static_cast<std::uint32_t>(self));
    if (descriptor >= 0 && !receive(descriptor, &now_us, sizeof(now_us))) {
      leave();
    }
  }
  void leave() { ::close(std::exchange(descriptor, -1)); }
  void sleep_until(std::int64_t deadline_us) {
    if (descriptor >= 0) {
      if (::send(descriptor, &deadline_us, sizeof(deadline_us), MSG_NOSIGNAL) == sizeof(deadline_us) &&
          receive(descriptor, &now_us, sizeof(now_us))) {
        return;
      }
      leave();
    }
    const std::int64_t rest_us = deadline_us - now_us;
    if (rest_us > 0) {
      timespec rest{.tv_sec = static_cast<time_t>(rest_us / 1000000),
                    .tv_nsec = static_cast<long>(rest_us % 1000000) * 1000};
      while (::nanosleep(&rest, &rest) != 0 && errno == EINTR) {
      }
      now_us = deadline_us;
    }
  }
};

Attendance attendance;

}  // namespace

int open_simulated(const std::string& port, std::uint32_t baud) {
  const int descriptor = connect_to(port, SimulatedPurpose::kPort, baud);
  if (descriptor < 0) {
    return -1;
  }
  std::uint8_t granted = 0;
  if (!receive(descriptor, &granted, sizeof(granted)) || granted == 0 ||
      ::fcntl(descriptor, F_SETFL, O_NONBLOCK) != 0) {
    ::close(descriptor);
    errno = EBUSY;
    return -1;
  }
  return descriptor;
}

PortClock::PortClock(const std::string& port) : host_(hal::is_simulated(port) ? port : "") {
  if (!host_.empty()) {
    attendance.join(host_);
    start_ = core::Duration{attendance.now_us};
  }
}

core::TimePoint PortClock::now() {
  if (host_.empty()) {
    return machine_.now();
  }
  attendance.join(host_);  // a forked process makes its own connection
  return core::TimePoint{core::Duration{attendance.now_us} - start_};
}

void PortClock::sleep_until(core::TimePoint deadline) {
  if (host_.empty()) {
    machine_.sleep_until(deadline);
    return;
  }
  attendance.join(host_);
  attendance.sleep_until((start_ + deadline.time_since_epoch()).count());
}

}  // namespace m100::hal
