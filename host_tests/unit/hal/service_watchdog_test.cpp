// SPDX-License-Identifier: BSD-3-Clause
#include "hal/linux/service_watchdog.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <string>

namespace m100::hal {
namespace {

/// The service manager's end of the socket.
class Manager {
 public:
  Manager() {
    address_.sun_family = AF_UNIX;
    const std::string path = "m100_watchdog_" + std::to_string(getpid());  // an abstract socket name
    std::memcpy(address_.sun_path + 1, path.data(), path.size());
    const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + path.size());
    EXPECT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&address_), length), 0);
    setenv("NOTIFY_SOCKET", ("@" + path).c_str(), 1);
  }
  ~Manager() {
    close(socket_);
    unsetenv("NOTIFY_SOCKET");
  }
  /// @returns what has arrived; empty: nothing.
  std::string heard() const {
    std::array<char, 256> words{};
    const ssize_t size = recv(socket_, words.data(), words.size(), MSG_DONTWAIT);
    return size > 0 ? std::string(words.data(), static_cast<std::size_t>(size)) : "";
  }

 private:
  int socket_ = socket(AF_UNIX, SOCK_DGRAM, 0);
  sockaddr_un address_{};
};

TEST(ServiceWatchdog, SaysThatItIsReadyAndThenTenTimesASecondThatItLives) {
  const Manager manager;
  ServiceWatchdog watchdog;
  EXPECT_EQ(manager.heard(), "") << "not ready before it starts";
  watchdog.start(std::chrono::seconds(1));
  const std::string ready = manager.heard();
  EXPECT_EQ(ready, "READY=1\nWATCHDOG_USEC=1000000\nWATCHDOG=1");
  for (int tick = 1; tick <= 100; ++tick) {
    watchdog.feed();
    EXPECT_EQ(manager.heard(), tick % 10 == 0 ? "WATCHDOG=1" : "") << tick;
  }
}

TEST(ServiceWatchdog, SaysThatItIsEndingSoThatWritingTheLogIsNoHang) {
  const Manager manager;
  ServiceWatchdog watchdog;
  watchdog.start(std::chrono::seconds(1));
  (void)manager.heard();
  watchdog.stop();
  EXPECT_EQ(manager.heard(), "STOPPING=1");
}

// The tick must not wait for a manager that reads nothing and so fills the socket.
TEST(ServiceWatchdog, DoesNotWaitForAManagerThatDoesNotListen) {
  const Manager manager;
  ServiceWatchdog watchdog;
  for (int tick = 0; tick < 100000; ++tick) {
    watchdog.feed();
  }
  EXPECT_EQ(manager.heard(), "WATCHDOG=1");
}

TEST(ServiceWatchdog, IsSilentWhereThereIsNoManager) {
  unsetenv("NOTIFY_SOCKET");
  ServiceWatchdog watchdog;
  watchdog.start(std::chrono::seconds(1));
  watchdog.feed();
  setenv("NOTIFY_SOCKET", std::string(200, 'x').c_str(), 1);  // longer than a socket name may be
  ServiceWatchdog other;
  other.start(std::chrono::seconds(1));
  unsetenv("NOTIFY_SOCKET");
}

}  // namespace
}  // namespace m100::hal
