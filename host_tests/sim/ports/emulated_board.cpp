// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/ports/emulated_board.h"

#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <bit>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <thread>
#include <vector>

namespace m100::sim {
namespace {

constexpr int kPatience_ms = 60000;  // only against a hang: long enough for a busy machine
constexpr std::size_t kControl = 0;
constexpr std::size_t kAutopilot = 1;
constexpr std::size_t kPose = 2;

[[noreturn]] void fail(const std::string& what) { throw std::runtime_error("emulated board: " + what); }

void wait_for(int descriptor, const char* what) {
  pollfd one{.fd = descriptor, .events = POLLIN, .revents = 0};
  if (poll(&one, 1, kPatience_ms) != 1) {
    fail(std::string("no answer: ") + what);
  }
}

hal::Descriptor listen_at(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof(address.sun_path)) {
    fail("the name of the temporary folder is too long: " + path);
  }
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  hal::Descriptor socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (::bind(socket.number, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 ||
      ::listen(socket.number, 1) != 0) {
    fail("cannot listen at " + path);
  }
  return socket;
}

}  // namespace

EmulatedBoard::EmulatedBoard(const std::string& image, const std::string& arguments) {
  if (!std::filesystem::exists(image)) {
    fail("image not found: " + image);
  }
  std::string pattern = (std::filesystem::temp_directory_path() / "m100_board_XXXXXX").string();
  if (::mkdtemp(pattern.data()) == nullptr) {
    fail("cannot create a temporary folder");
  }
  folder_ = pattern;
  for (std::size_t port = 0; port < kPorts; ++port) {
    listening_[port] = listen_at(folder_ + "/uart" + std::to_string(port));
  }
  start(image, arguments);
  for (std::size_t port = 0; port < kPorts; ++port) {
    wait_for(listening_[port].number, "the emulator did not connect");
    socket_[port] = hal::Descriptor(::accept4(listening_[port].number, nullptr, nullptr, SOCK_CLOEXEC));
  }
}

EmulatedBoard::~EmulatedBoard() {
  if (emulator_ > 0) {
    ::kill(emulator_, SIGKILL);
    ::waitpid(emulator_, nullptr, 0);
  }
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void EmulatedBoard::start(const std::string& image, const std::string& arguments) {
  std::vector<std::string> words{"qemu-system-arm", "-M", "mps2-an500", "-display", "none", "-monitor", "none"};
  for (std::size_t port = 0; port < kPorts; ++port) {
    words.insert(words.end(), {"-serial", "unix:" + folder_ + "/uart" + std::to_string(port)});
  }
  std::string semihosting = "enable=on,target=native,arg=image";
  for (std::size_t at = 0; at < arguments.size();) {
    const std::size_t end = std::min(arguments.find(' ', at), arguments.size());
    semihosting += ",arg=" + arguments.substr(at, end - at);
    at = end + 1;
  }
  words.insert(words.end(), {"-icount", "shift=0", "-semihosting-config", semihosting, "-kernel", image});
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) {
    argv.push_back(word.data());
  }
  argv.push_back(nullptr);
  emulator_ = ::fork();
  if (emulator_ == 0) {
    ::execvp(argv[0], argv.data());
    ::_exit(127);
  }
}

void EmulatedBoard::send(std::size_t port, const std::byte* data, std::size_t size) {
  while (size > 0) {
    const ssize_t count = ::send(socket_[port].number, data, size, MSG_NOSIGNAL);
    if (count <= 0) {
      fail("UART" + std::to_string(port) + " is gone");
    }
    data += count;
    size -= static_cast<std::size_t>(count);
  }
}

void EmulatedBoard::receive(std::size_t port, std::byte* data, std::size_t size) {
  while (size > 0) {
    wait_for(socket_[port].number, ("UART" + std::to_string(port)).c_str());
    const ssize_t count = ::recv(socket_[port].number, data, size, 0);
    if (count <= 0) {
      fail("UART" + std::to_string(port) + " is gone");
    }
    data += count;
    size -= static_cast<std::size_t>(count);
  }
}

std::uint32_t EmulatedBoard::pass_on(hal::Uart& from, std::size_t port) {
  std::array<std::byte, 256> bytes{};
  for (std::size_t count = from.read(bytes).value_or(0); count > 0; count = from.read(bytes).value_or(0)) {
    send(port, bytes.data(), count);
    sent_[port] += static_cast<std::uint32_t>(count);
  }
  return sent_[port];
}

void EmulatedBoard::bring_back(std::size_t port, std::uint32_t& so_far, std::uint32_t total, hal::Uart& to) {
  std::vector<std::byte> bytes(total - so_far);
  receive(port, bytes.data(), bytes.size());
  so_far = total;
  if (to.write(bytes).value_or(0) != bytes.size()) {
    fail("the simulated line has no room for the board's bytes");
  }
}

hal::LockstepReport EmulatedBoard::step(core::TimePoint now, hal::LockstepOrder order, hal::Uart& autopilot,
                                        hal::Uart& pose) {
  const hal::LockstepStep step{.now_us = static_cast<std::uint32_t>(now.time_since_epoch().count()),
                               .order = order,
                               .autopilot_bytes = pass_on(autopilot, kAutopilot),
                               .pose_bytes = pass_on(pose, kPose)};
  const auto out = std::bit_cast<std::array<std::byte, sizeof(step)>>(step);
  send(kControl, out.data(), out.size());
  std::array<std::byte, sizeof(hal::LockstepReport)> in{};
  receive(kControl, in.data(), in.size());
  const auto report = std::bit_cast<hal::LockstepReport>(in);
  bring_back(kAutopilot, received_[kAutopilot], report.autopilot_bytes, autopilot);
  bring_back(kPose, received_[kPose], report.pose_bytes, pose);
  return report;
}

void EmulatedBoard::order_last(hal::LockstepOrder order) {
  const hal::LockstepStep step{
      .now_us = 0, .order = order, .autopilot_bytes = sent_[kAutopilot], .pose_bytes = sent_[kPose]};
  const auto out = std::bit_cast<std::array<std::byte, sizeof(step)>>(step);
  send(kControl, out.data(), out.size());
}

int EmulatedBoard::wait_for_exit() {
  for (int waited_ms = 0; waited_ms < kPatience_ms; waited_ms += 10) {
    int status = 0;
    if (::waitpid(emulator_, &status, WNOHANG) == emulator_) {
      emulator_ = -1;
      return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return -1;
}

int EmulatedBoard::end() {
  order_last(hal::LockstepOrder::kEnd);
  return wait_for_exit();
}

int EmulatedBoard::last_words(hal::LockstepOrder order, hal::Uart& autopilot) {
  order_last(order);
  const int status = wait_for_exit();
  std::array<std::byte, 1024> bytes{};
  for (ssize_t count = 1; count > 0;) {  // bytes that the emulator sent before it ended are still in the socket
    count = ::recv(socket_[kAutopilot].number, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (count > 0) {
      (void)autopilot.write(std::span(bytes).first(static_cast<std::size_t>(count)));
    }
  }
  return status;
}

}  // namespace m100::sim
