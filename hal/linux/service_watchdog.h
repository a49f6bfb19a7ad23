// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include "hal/watchdog.h"

namespace m100::hal {

/// The service manager as a watchdog: what it set in $NOTIFY_SOCKET hears that the program is ready and that it lives
/// (sd_notify(3)); where there is none, every call does nothing. feed() costs a datagram every tenth call, never waits
/// and takes no memory.
class ServiceWatchdog final : public Watchdog {
 public:
  ServiceWatchdog();
  ~ServiceWatchdog();

  /// Says "ready", and for how long silence may last.
  void start(core::Duration patience) override;
  void feed() override;
  /// Says that the program is ending: what it still has to write and to say may take longer than the patience.
  void stop();

 private:
  void tell(const char* words) const;

  int socket_ = -1;
  sockaddr_un manager_{};
  socklen_t length_ = 0;
  unsigned calls_ = 0;
};

}  // namespace m100::hal
