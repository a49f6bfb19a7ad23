// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/ports/lockstep_host.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <utility>

#include "hal/linux/simulated_port.h"

namespace m100::sim {
namespace {

constexpr int kLook_ms = 50;          // interval of checks of a program that does not go back to sleep
constexpr int kPatience_looks = 400;  // after this many checks time continues without it
constexpr int kHelloPatience_ms = 1000;

/// T: stopped, Z: zombie (ended, not yet waited for); 0: there is no such process.
char process_state(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  std::string text;
  std::getline(file, text);
  const std::size_t name_end = text.rfind(')');
  return name_end == std::string::npos || name_end + 2 >= text.size() ? '\0' : text[name_end + 2];
}

pid_t peer_of(int descriptor) {
  ucred peer{};
  socklen_t size = sizeof(peer);
  return ::getsockopt(descriptor, SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0 ? peer.pid : -1;
}

template <typename T>
bool send_all(int descriptor, const T& value) {
  return ::send(descriptor, &value, sizeof(value), MSG_NOSIGNAL) == static_cast<ssize_t>(sizeof(value));
}

}  // namespace

LockstepHost::~LockstepHost() {
  for (EndState& end : ends_) {
    hang_up(end);
    ::close(end.listening);
    ::unlink(end.path.c_str());
  }
  for (const AttachedProgram& program : programs_) {
    ::close(program.descriptor);
  }
}

LockstepHost::End LockstepHost::add_end(const std::string& path) {
  ends_.push_back({.path = path});
  listen(ends_.back());
  return ends_.size() - 1;
}

/// The socket gets its name only when it listens, so that a program that sees the name can connect.
void LockstepHost::listen(EndState& end) {
  const std::string unnamed = end.path + "~";
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (unnamed.size() >= sizeof(address.sun_path)) {
    throw std::runtime_error(end.path + ": too long for a socket name");
  }
  std::memcpy(address.sun_path, unnamed.c_str(), unnamed.size() + 1);
  ::unlink(unnamed.c_str());
  end.listening = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (end.listening < 0 || ::bind(end.listening, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 ||
      ::listen(end.listening, 8) != 0 || ::rename(unnamed.c_str(), end.path.c_str()) != 0) {
    throw std::runtime_error(end.path + ": " + std::strerror(errno));
  }
}

void LockstepHost::hang_up(EndState& end) {
  if (end.descriptor >= 0) {
    // A process that another thread is starting holds a copy of the descriptor until exec; with close() alone the peer
    // would see the hang-up only then.
    ::shutdown(end.descriptor, SHUT_RDWR);
    ::close(end.descriptor);
  }
  end.descriptor = -1;
  end.process = -1;
  end.baud = 0;
  end.waiting.clear();
}

void LockstepHost::unplug(End end) {
  receive(ends_[end]);
  hang_up(ends_[end]);
  ::close(ends_[end].listening);
  ends_[end].listening = -1;
  ::unlink(ends_[end].path.c_str());
}

void LockstepHost::plug_in(End end) { listen(ends_[end]); }

void LockstepHost::receive(EndState& end) {
  std::array<std::byte, 4096> bytes;
  while (end.descriptor >= 0) {
    const ssize_t count = ::recv(end.descriptor, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (count > 0) {
      end.written.insert(end.written.end(), bytes.begin(), bytes.begin() + count);
    } else if (count < 0 && (errno == EAGAIN || errno == EINTR)) {
      return;
    } else {
      hang_up(end);
    }
  }
}

std::vector<std::byte> LockstepHost::take(End end) {
  receive(ends_[end]);
  return std::exchange(ends_[end].written, {});
}

void LockstepHost::give(End end, std::span<const std::byte> bytes) {
  EndState& to = ends_[end];
  if (to.descriptor >= 0) {
    const std::size_t room = kWaitingBytes - std::min(kWaitingBytes, to.waiting.size());
    const std::span<const std::byte> kept = bytes.first(std::min(room, bytes.size()));
    to.waiting.insert(to.waiting.end(), kept.begin(), kept.end());
  }
}

void LockstepHost::hand_over(pid_t process) {
  for (EndState& end : ends_) {
    if (end.process == process && !end.waiting.empty()) {
      const ssize_t count = ::send(end.descriptor, end.waiting.data(), end.waiting.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
      end.waiting.erase(end.waiting.begin(), end.waiting.begin() + std::max<ssize_t>(count, 0));
    }
  }
}

void LockstepHost::accept_end(EndState& end) {
  const int descriptor = ::accept4(end.listening, nullptr, nullptr, SOCK_CLOEXEC);
  if (descriptor < 0) {
    return;
  }
  hal::SimulatedHello hello{};
  pollfd one{.fd = descriptor, .events = POLLIN, .revents = 0};
  if (::poll(&one, 1, kHelloPatience_ms) != 1 ||
      ::recv(descriptor, &hello, sizeof(hello), MSG_WAITALL) != static_cast<ssize_t>(sizeof(hello))) {
    ::close(descriptor);
    return;
  }
  if (hello.purpose == hal::SimulatedPurpose::kClock) {
    const std::int64_t now_us = now_.time_since_epoch().count();
    const pid_t process = peer_of(descriptor);
    if (send_all(descriptor, now_us)) {
      programs_.push_back({.descriptor = descriptor, .process = process, .deadline_us = now_us});
    }
    return;
  }
  receive(end);  // the present holder may have disconnected
  const auto granted = static_cast<std::uint8_t>(end.descriptor < 0);
  if (!send_all(descriptor, granted) || granted == 0) {
    ::close(descriptor);
    return;
  }
  end.descriptor = descriptor;
  end.process = peer_of(descriptor);
  end.baud = hello.value;
  end.waiting.clear();
}

void LockstepHost::receive(AttachedProgram& program) {
  const ssize_t count =
      ::recv(program.descriptor, &program.deadline_us, sizeof(program.deadline_us), MSG_DONTWAIT | MSG_WAITALL);
  if (count == static_cast<ssize_t>(sizeof(program.deadline_us))) {
    program.asleep = true;
    program.seen_stopped = false;
  } else if (count >= 0 || errno != EAGAIN) {
    ::close(program.descriptor);
    program.descriptor = -1;
  }
}

void LockstepHost::drop_ended() {
  std::erase_if(programs_, [](const AttachedProgram& program) { return program.descriptor < 0; });
}

void LockstepHost::service(int patience_ms) {
  std::vector<pollfd> watched;
  for (const EndState& end : ends_) {
    watched.push_back({.fd = end.listening, .events = POLLIN, .revents = 0});
  }
  const std::size_t first_attendant = watched.size();
  const std::size_t known = programs_.size();
  for (const AttachedProgram& program : programs_) {
    watched.push_back({.fd = program.descriptor, .events = POLLIN, .revents = 0});
  }
  if (::poll(watched.data(), watched.size(), patience_ms) <= 0) {
    return;
  }
  for (std::size_t i = 0; i < known; ++i) {
    if (watched[first_attendant + i].revents != 0 && programs_[i].descriptor >= 0) {
      receive(programs_[i]);
    }
  }
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    if (watched[i].revents != 0) {
      accept_end(ends_[i]);
    }
  }
}

void LockstepHost::await_sleep(std::size_t index) {
  for (int looks = 0; looks < kPatience_looks && !stopped_; ++looks) {
    service(kLook_ms);
    const AttachedProgram& awaited = programs_[index];
    if (awaited.asleep || awaited.descriptor < 0) {
      return;
    }
    const char state = process_state(awaited.process);
    if (state == 'T') {
      break;
    }
    if (state == 'Z' || state == '\0') {  // another process still holds its socket
      ::close(awaited.descriptor);
      programs_[index].descriptor = -1;
      return;
    }
  }
  programs_[index].seen_stopped = true;
}

void LockstepHost::wake(std::size_t index) {
  hand_over(programs_[index].process);
  programs_[index].asleep = false;
  const std::int64_t now_us = now_.time_since_epoch().count();
  if (!send_all(programs_[index].descriptor, now_us)) {
    receive(programs_[index]);
    return;
  }
  await_sleep(index);
  for (EndState& end : ends_) {
    receive(end);
  }
}

void LockstepHost::wait_for_newcomers() {
  for (std::size_t i = 0; i < programs_.size() && !stopped_; ++i) {  // others may connect meanwhile
    if (!programs_[i].asleep && !programs_[i].seen_stopped && programs_[i].descriptor >= 0) {
      await_sleep(i);
    }
  }
  drop_ended();
}

void LockstepHost::advance(core::TimePoint until) {
  service(0);
  drop_ended();
  wait_for_newcomers();
  const auto runs = [this](const AttachedProgram& program) {
    return program.asleep && std::find(suspended_.begin(), suspended_.end(), program.process) == suspended_.end();
  };
  std::int64_t next_us = until.time_since_epoch().count();
  for (const AttachedProgram& program : programs_) {
    next_us = runs(program) ? std::min(next_us, program.deadline_us) : next_us;
  }
  now_ = std::max(now_, core::TimePoint{core::Duration{next_us}});
  const std::size_t present = programs_.size();
  for (std::size_t i = 0; i < present && !stopped_; ++i) {
    if (programs_[i].descriptor >= 0 && runs(programs_[i]) &&
        programs_[i].deadline_us <= now_.time_since_epoch().count()) {
      wake(i);
    }
  }
  drop_ended();
}

bool LockstepHost::wait_for(const std::function<bool()>& condition, double at_most_s) {
  constexpr int kStep_ms = 10;
  for (int left = static_cast<int>(at_most_s * 1000.0 / kStep_ms); left > 0 && !stopped_; --left) {
    service(kStep_ms);
    drop_ended();
    if (condition()) {
      return true;
    }
  }
  return condition();
}

bool LockstepHost::is_attached(pid_t process) const {
  return std::any_of(programs_.begin(), programs_.end(),
                     [&](const AttachedProgram& program) { return program.process == process; });
}

void LockstepHost::suspend(pid_t process) { suspended_.push_back(process); }

void LockstepHost::resume(pid_t process) { std::erase(suspended_, process); }

}  // namespace m100::sim
