// SPDX-License-Identifier: BSD-3-Clause
#include "hal/linux/service_watchdog.h"

#include <cinttypes>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace m100::hal {
namespace {

constexpr unsigned kFeedsPerNotify = 10;  ///< calls of feed() per heartbeat: ten a second if called every tick

}  // namespace

ServiceWatchdog::ServiceWatchdog() {
  const char* const path = std::getenv("NOTIFY_SOCKET");
  const std::size_t size = path == nullptr ? 0 : std::strlen(path);
  if (size == 0 || size >= sizeof manager_.sun_path) {
    return;
  }
  manager_.sun_family = AF_UNIX;
  std::memcpy(manager_.sun_path, path, size);
  if (path[0] == '@') {  // a name without a file
    manager_.sun_path[0] = '\0';
  }
  length_ = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + size);
  socket_ = Descriptor(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
}

void ServiceWatchdog::notify(const char* words) const {
  if (socket_.number >= 0) {  // if the manager does not listen now, the next heartbeat follows in 0.1 s
    (void)::sendto(socket_.number, words, std::strlen(words), MSG_DONTWAIT | MSG_NOSIGNAL,
                   reinterpret_cast<const sockaddr*>(&manager_), length_);
  }
}

void ServiceWatchdog::start(core::Duration patience) {
  char words[64];
  std::snprintf(words, sizeof words, "READY=1\nWATCHDOG_USEC=%" PRId64 "\nWATCHDOG=1",
                static_cast<std::int64_t>(patience.count()));
  notify(words);
}

void ServiceWatchdog::stop() { notify("STOPPING=1"); }

void ServiceWatchdog::feed() {
  if (++calls_ % kFeedsPerNotify == 0) {
    notify("WATCHDOG=1");
  }
}

}  // namespace m100::hal
