// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/operator/terminal.h"

#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>

namespace m100::companion {
namespace {

/// Whether the descriptor has room for output; waits at most `patience`.
bool takes(int descriptor, std::chrono::milliseconds patience) {
  pollfd screen{.fd = descriptor, .events = POLLOUT, .revents = 0};
  return poll(&screen, 1, static_cast<int>(patience.count())) > 0 && (screen.revents & POLLOUT) != 0;
}

}  // namespace

void make_terminals_nonblocking() {
  for (const int descriptor : {STDOUT_FILENO, STDERR_FILENO}) {
    if (isatty(descriptor) != 1) {
      continue;
    }
    std::array<char, 32> path{};
    std::snprintf(path.data(), path.size(), "/proc/self/fd/%d", descriptor);
    const int anew = open(path.data(), O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (anew >= 0) {
      (void)dup2(anew, descriptor);
      (void)close(anew);
    }
  }
}

void write_nonblocking(int descriptor, std::string_view text) {
  if (takes(descriptor, std::chrono::milliseconds(0))) {
    (void)!::write(descriptor, text.data(), text.size());
  }
}

void write_with_timeout(std::string_view text) {
  // A pipe with room takes PIPE_BUF bytes at once; a terminal takes as much as it has room for.
  while (!text.empty() && takes(STDOUT_FILENO, kTerminalTimeout)) {
    const ssize_t count = ::write(STDOUT_FILENO, text.data(), std::min<std::size_t>(text.size(), PIPE_BUF));
    if (count < 0 && errno != EAGAIN && errno != EINTR) {
      return;  // there is no reader
    }
    text.remove_prefix(count > 0 ? static_cast<std::size_t>(count) : 0);
  }
}

}  // namespace m100::companion
