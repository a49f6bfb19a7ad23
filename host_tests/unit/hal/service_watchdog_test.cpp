// SPDX-License-Identifier: BSD-3-Clause
#include "hal/linux/service_watchdog.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <string>

#include "host_tests/unit/hal/far_side.h"

namespace m100::hal {
namespace {

/// The service manager's end of the socket.
class Manager {
 public:
  /// @param first '@': an abstract name; '/': a file. @param size of the name.
  explicit Manager(char first = '@', std::size_t size = 40) : name_(first == '@' ? "@m100_" : "/tmp/m100_") {
    name_ += std::to_string(getpid()) + std::string(size, 'x');
    name_.resize(size);
    address_.sun_family = AF_UNIX;
    std::memcpy(address_.sun_path, name_.data(), size);
    address_.sun_path[0] = first == '@' ? '\0' : first;
    const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + size);
    EXPECT_EQ(bind(socket_.number, reinterpret_cast<const sockaddr*>(&address_), length), 0);
    setenv("NOTIFY_SOCKET", name_.c_str(), 1);
  }
  ~Manager() {
    unlink(name_.c_str());
    unsetenv("NOTIFY_SOCKET");
  }
  /// @returns what has arrived; empty: nothing.
  std::string heard() const {
    std::array<char, 256> words{};
    const ssize_t size = recv(socket_.number, words.data(), words.size(), MSG_DONTWAIT);
    return size > 0 ? std::string(words.data(), static_cast<std::size_t>(size)) : "";
  }

 private:
  Descriptor socket_ = not_zero(socket(AF_UNIX, SOCK_DGRAM, 0));
  sockaddr_un address_{};
  std::string name_;
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

// Names of each kind, and up to the longest, with descriptor 0 as well; it leaves no file open.
TEST(ServiceWatchdog, SaysThatItIsEndingSoThatWritingTheLogIsNoHang) {
  for (const auto& [first, size] : {std::pair{'@', std::size_t{40}}, {'/', 40}, {'@', 107}, {'/', 107}, {'@', 108}}) {
    const Manager manager(first, size);
    free_descriptor_zero();
    const auto open = open_files();
    {
      ServiceWatchdog watchdog;
      watchdog.stop();
      EXPECT_EQ(manager.heard(), size < 108 ? "STOPPING=1" : "") << first << size;
    }
    EXPECT_EQ(open_files(), open);
  }
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
}

}  // namespace
}  // namespace m100::hal
