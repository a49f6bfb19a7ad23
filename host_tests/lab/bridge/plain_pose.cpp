// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/bridge/plain_pose.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>

#include "protocol/bytes.h"

namespace m100::lab::bridge {
namespace {

constexpr std::size_t kNumbers = 8;
constexpr double kFarthest_m = 1000.0;
constexpr double kLengthError = 0.02;  // tolerance of the squared length
constexpr double kLatest_s = 9e9;
using Numbers = std::array<double, kNumbers>;

bool is_between(char letter) {
  return letter == ' ' || letter == ',' || letter == '\t' || letter == '\n' || letter == '\r';
}

std::optional<Numbers> of_text(std::string_view text) {
  Numbers numbers{};
  const char* at = text.data();
  const char* const end = at + text.size();
  for (double& number : numbers) {
    for (; at != end && is_between(*at); ++at) {
    }
    const std::from_chars_result read = std::from_chars(at, end, number);
    if (read.ec != std::errc{} || (read.ptr != end && !is_between(*read.ptr))) {
      return {};
    }
    at = read.ptr;
  }
  for (; at != end && is_between(*at); ++at) {
  }
  return at == end ? std::optional(numbers) : std::nullopt;
}

Numbers of_bytes(std::span<const std::byte> packet) {
  Numbers numbers{};
  for (std::size_t i = 0; i < kNumbers; ++i) {
    numbers[i] = protocol::load<double>(packet.data() + i * sizeof(double));
  }
  return numbers;
}

}  // namespace

std::optional<Axes> axes_of(std::string_view word) {
  return word == "nwu"   ? std::optional(Axes::kNwu)
         : word == "ned" ? std::optional(Axes::kNed)
         : word == "enu" ? std::optional(Axes::kEnu)
                         : std::nullopt;
}

std::optional<PlainPose> parse_packet(std::span<const std::byte> packet, link::PoseFault* fault) {
  // Text first: a packet of 64 bytes may be text, but doubles of a plausible pose never look like text of numbers.
  std::optional<Numbers> read = of_text({reinterpret_cast<const char*>(packet.data()), packet.size()});
  if (!read && packet.size() == kNumbers * sizeof(double)) {
    read = of_bytes(packet);
  }
  if (!read) {
    return {};
  }
  const auto& [t, x, y, z, qw, qx, qy, qz] = *read;
  const PlainPose pose{.t_s = t, .position_m = {x, y, z}, .body_to_world = {qw, qx, qy, qz}};
  const link::PoseFault found = fault_of(pose);
  if (fault != nullptr) {
    *fault = found;
  }
  return found == link::PoseFault::kNone ? std::optional(pose) : std::nullopt;
}

link::PoseFault fault_of(const PlainPose& pose) {
  using link::PoseFault;
  const core::Quaternion<double>& q = pose.body_to_world;
  const double squared = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  if (!std::isfinite(squared + pose.position_m.sum() + pose.t_s)) {
    return PoseFault::kNotFinite;
  }
  if (squared <= 0.0 && pose.position_m.isZero(0.0)) {
    return PoseFault::kZeros;
  }
  if (!(squared >= 1.0 - kLengthError && squared <= 1.0 + kLengthError)) {
    return PoseFault::kQuaternion;
  }
  return pose.t_s > kLatest_s || pose.t_s < 0.0                ? PoseFault::kFastStamp
         : pose.position_m.cwiseAbs().maxCoeff() > kFarthest_m ? PoseFault::kMillimetres
                                                               : PoseFault::kNone;
}

mavlink::AttPosMocap message_of(const PlainPose& pose, Axes axes, std::uint64_t time_usec) {
  core::Vector<double, 3> p = pose.position_m;
  core::Quaternion<double> q = pose.body_to_world;
  if (axes == Axes::kEnu) {  // to NWU: a quarter turn about z, so that x is north
    const double half = std::sqrt(0.5);
    p = {pose.position_m.y(), -pose.position_m.x(), pose.position_m.z()};
    q = {half * (q.w + q.z), half * (q.x + q.y), half * (q.y - q.x), half * (q.z - q.w)};
  }
  if (axes != Axes::kNed) {
    p = core::flip_yz(p);
    q = core::flip_yz(q);
  }
  mavlink::AttPosMocap message;
  message.time_usec = time_usec;
  message.q = {static_cast<float>(q.w), static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)};
  message.x = static_cast<float>(p.x());
  message.y = static_cast<float>(p.y());
  message.z = static_cast<float>(p.z());
  return message;
}

}  // namespace m100::lab::bridge
