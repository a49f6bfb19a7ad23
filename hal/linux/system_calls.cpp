// SPDX-License-Identifier: BSD-3-Clause
#include "hal/linux/system_calls.h"

#include <fcntl.h>
#include <sys/ioctl.h>

namespace m100::hal {

int open_device(const char* path) { return ::open(path, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC); }

int read_line_counters(int descriptor, serial_icounter_struct* counters) {
  return ioctl(descriptor, TIOCGICOUNT, counters);
}

int count_waiting(int descriptor, int* bytes) { return ioctl(descriptor, FIONREAD, bytes); }

const SystemCalls& real_system_calls() {
  static constexpr SystemCalls kReal{};
  return kReal;
}

}  // namespace m100::hal
