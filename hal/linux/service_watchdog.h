// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include "hal/linux/descriptor.h"
#include "hal/watchdog.h"

namespace m100::hal {

/// The service manager as a watchdog: the socket named by $NOTIFY_SOCKET receives "ready" and the heartbeats
/// (sd_notify(3)). Without that variable every call does nothing. feed() sends a datagram every tenth call, never waits
/// and allocates nothing.
class ServiceWatchdog final : public Watchdog {
 public:
  ServiceWatchdog();

  /// Reports "ready" and the longest permitted time between heartbeats.
  void start(core::Duration patience) override;
  void feed() override;
  /// Reports that the program is ending: its last output may take longer than the patience.
  void stop();

 private:
  void notify(const char* words) const;

  Descriptor socket_;
  sockaddr_un manager_{};
  socklen_t length_ = 0;
  unsigned calls_ = 0;
};

}  // namespace m100::hal
