// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/body/physics_link.h"

#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <thread>

namespace m100::sim {
namespace {

using std::chrono::milliseconds;

constexpr double kMinStep_s = 1e-4;
constexpr double kRounding_s = 1e-6;  // of a time stamp that is a sum of steps
constexpr double kMaxStep_s = 0.010;  // above it ArduPilot does not take the step as its frame rate
constexpr double kNotLate_s = 0.1;    // no answer can be so late: at most one step is under way
constexpr milliseconds kLook{50};     // between two looks at a program that has not answered yet
constexpr std::size_t kMaxAnswer = 65536;

std::string printed(const char* format, double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}
std::string milliseconds_of(double seconds) { return printed("%.4g ms", 1e3 * seconds); }
std::string seconds_of(double seconds) { return printed("%.4f s", seconds); }

}  // namespace

PhysicsLink::PhysicsLink(const PhysicsAddress& address, std::uint16_t rate_hz, const Patience& patience)
    : address_(address), name_("json:" + address.host + ":" + std::to_string(address.port)), patience_(patience) {
  packet_.rate_hz = rate_hz;
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (const int wrong = ::getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &found);
      wrong != 0) {
    fail(::gai_strerror(wrong));
  }
  std::memcpy(&to_, found->ai_addr, found->ai_addrlen);
  to_size_ = found->ai_addrlen;
  ::freeaddrinfo(found);
  socket_ = hal::Descriptor(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  // Not connected, so that a program that answers from another socket is understood; with this option the kernel still
  // reports that nothing listens at the port.
  const int on = 1;
  if (socket_.number < 0 || ::setsockopt(socket_.number, IPPROTO_IP, IP_RECVERR, &on, sizeof(on)) != 0) {
    fail(std::strerror(errno));
  }
}

void PhysicsLink::fail(const std::string& what) const {
  throw PhysicsError(name_ + ": frame " + std::to_string(packet_.frame) + ": " + what);
}

void PhysicsLink::send(const ServoPacket& packet) {
  const std::array<std::byte, ServoPacket::kBytes> bytes = encode(packet);
  const auto* const to = reinterpret_cast<const sockaddr*>(&to_);
  // The first attempt may only report that an earlier packet found nobody.
  if (::sendto(socket_.number, bytes.data(), bytes.size(), 0, to, to_size_) < 0 &&
      ::sendto(socket_.number, bytes.data(), bytes.size(), 0, to, to_size_) < 0 && errno != ECONNREFUSED) {
    fail(std::strerror(errno));
  }
}

/// Drops what has come since the last answer: repeated answers, which would make every later one a step old.
void PhysicsLink::drop_waiting() {
  std::array<char, 1> begin{};
  while (::recv(socket_.number, begin.data(), begin.size(), MSG_DONTWAIT) >= 0) {
    ++dropped_;
  }
}

void PhysicsLink::check_program() {
  if (address_.program != nullptr && !address_.program->ending().empty()) {
    fail("the physics program has ended with " + address_.program->ending());
  }
}

/// @returns nothing: no answer within `at_most`, or a dropped one.
std::optional<PhysicsAnswer> PhysicsLink::receive(milliseconds at_most) {
  pollfd one{.fd = socket_.number, .events = POLLIN, .revents = 0};
  if (::poll(&one, 1, static_cast<int>(at_most.count())) <= 0) {
    check_program();
    return std::nullopt;
  }
  thread_local std::array<char, kMaxAnswer> bytes;
  const ssize_t count = ::recv(socket_.number, bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (count < 0) {
    // Reading the report of an error leaves it in the error queue as well.
    std::array<char, 512> report{};
    iovec into{.iov_base = report.data(), .iov_len = report.size()};
    msghdr message{};
    message.msg_iov = &into;
    message.msg_iovlen = 1;
    while (::recvmsg(socket_.number, &message, MSG_ERRQUEUE | MSG_DONTWAIT) >= 0) {
    }
    if (last_s_) {
      check_program();
      fail("the physics program has ended: nothing listens at its port any more");
    }
    check_program();
    refused_ = true;
    std::this_thread::sleep_for(kLook);
    return std::nullopt;
  }
  const PhysicsAnswer answer = read({bytes.data(), static_cast<std::size_t>(count)});
  return is_new(answer) ? std::optional(answer) : std::nullopt;
}

PhysicsAnswer PhysicsLink::read(std::string_view datagram) const {
  try {
    return decode_answer(datagram);
  } catch (const PhysicsError& wrong) {
    fail(wrong.what());
  }
}

bool PhysicsLink::is_new(const PhysicsAnswer& answer) {
  if (!last_s_) {
    return true;
  }
  const double step_s = answer.time_s - *last_s_;
  if (step_s < -kNotLate_s) {
    fail("the physics program has begun anew: its time stamp went back from " + seconds_of(*last_s_) + " to " +
         seconds_of(answer.time_s));
  }
  if (step_s <= 0.0) {
    ++dropped_;
    return false;
  }
  if (step_s > kMaxStep_s - kRounding_s || step_s < kMinStep_s - kRounding_s) {
    fail("the physics program steps by " + milliseconds_of(step_s) + "; the frame rate asks for " +
         milliseconds_of(1.0 / packet_.rate_hz) + ", and " + milliseconds_of(kMinStep_s) + " to below " +
         milliseconds_of(kMaxStep_s) + " are possible");
  }
  return true;
}

PhysicsAnswer PhysicsLink::exchange(const std::array<std::uint16_t, 16>& pulse_us) {
  packet_.pulse_us = pulse_us;
  const milliseconds patience = last_s_ ? patience_.later : patience_.first;
  const Clock::time_point began = Clock::now();
  Clock::time_point sent = began;
  drop_waiting();
  send(packet_);
  const std::uint64_t dropped_before = dropped_;
  for (Clock::time_point now = began; now - began < patience; now = Clock::now()) {
    if (const std::optional<PhysicsAnswer> answer = receive(kLook)) {
      last_s_ = answer->time_s;
      ++packet_.frame;
      return *answer;
    }
    if (refused_ || Clock::now() - sent >= patience_.again) {
      refused_ = false;
      send(packet_);
      sent = Clock::now();
    }
  }
  fail(dropped_ > dropped_before ? "the physics program's time stands still"
                                 : "no answer within " + std::to_string(patience.count() / 1000) + " s" +
                                       (last_s_ ? "" : "; is the physics program running, and is this its port?"));
}

}  // namespace m100::sim
