// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "host_tests/lab/bridge/plain_pose.h"

namespace m100::lab::bridge {

/// What both ends of a VRPN connection say first, 24 bytes.
inline constexpr std::size_t kVrpnCookieBytes = 24;
std::array<std::byte, kVrpnCookieBytes> vrpn_cookie();

/// The stream that a VRPN server sends over TCP: its cookie, then messages, big endian,
///   i32 length of header and body | i32 s | i32 us | i32 sender | i32 type | u32 number | body | filler to 8 bytes
/// Senders and types are names that the server gives numbers to in messages of type -1 and -2 (body: i32 length, name
/// with its zero; the number stands where the sender does). Of type "vrpn_Tracker Pos_Quat" the body is i32 sensor,
/// i32 filler, three doubles, quaternion x y z w. All else is passed over.
///
/// Whatever the bytes are: at most kMostBytes of them wait for their end, at most kMostNames senders and types are
/// known with at most kMostNameBytes each (VRPN's own limit; a longer name is passed over), and a length that cannot be
/// ends the stream.
class VrpnStream {
 public:
  static constexpr std::size_t kMostBytes = 1U << 16U;
  static constexpr std::size_t kMostNames = 1000;
  static constexpr std::size_t kMostNameBytes = 100;  ///< with the zero
  using Use = std::function<void(const PlainPose&)>;

  /// @param tracker whose poses count. @param sensor of it.
  VrpnStream(std::string tracker, std::int32_t sensor) : tracker_(std::move(tracker)), sensor_(sensor) {}

  /// @param use is called with each pose. @returns false: this is no VRPN, or not any more.
  bool consume(std::span<const std::byte> bytes, const Use& use);
  std::uint64_t messages() const { return messages_; }
  /// Poses of other trackers or sensors, and such as are none.
  std::uint64_t passed_over() const { return passed_over_; }
  /// The names that have come, for whoever named another.
  std::vector<std::string> senders() const;
  /// Why there is no pose: the tracker that was named is none of those that the server has, or has another sensor.
  /// Names are the server's own bytes.
  std::string why_none() const;

 private:
  void take(std::span<const std::byte> message, const Use& use);
  void learn(std::map<std::int32_t, std::string>& names, std::int32_t number, std::span<const std::byte> body);

  std::string tracker_;
  std::int32_t sensor_;
  std::vector<std::byte> waiting_;
  bool has_cookie_ = false;
  std::map<std::int32_t, std::string> senders_, types_;
  std::uint64_t messages_ = 0;
  std::uint64_t passed_over_ = 0;
};

}  // namespace m100::lab::bridge
