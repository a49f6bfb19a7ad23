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

/// The 24 bytes that both ends of a VRPN connection send first.
inline constexpr std::size_t kVrpnCookieBytes = 24;
std::array<std::byte, kVrpnCookieBytes> vrpn_cookie();

/// The stream that a VRPN server sends over TCP: its cookie, then messages, big endian,
///   i32 length of header and body | i32 s | i32 us | i32 sender | i32 type | u32 number | body | filler to 8 bytes
/// The server numbers the names of senders and types in messages of type -1 and -2 (body: i32 length, name with its
/// zero; the sender field holds the number). In type "vrpn_Tracker Pos_Quat" the body is i32 sensor, i32 filler and
/// seven doubles, position x y z and quaternion x y z w. All other messages are ignored.
///
/// Whatever the bytes are: at most kMaxBytes of an incomplete message are stored; at most kMaxNames senders and as many
/// types are stored, each with at most kMaxNameBytes (VRPN's own limit; longer names are ignored). An impossible length
/// ends the stream.
class VrpnStream {
 public:
  static constexpr std::size_t kMaxBytes = 1U << 16U;
  static constexpr std::size_t kMaxNames = 1000;
  static constexpr std::size_t kMaxNameBytes = 100;  ///< with the zero
  using Use = std::function<void(const PlainPose&)>;

  /// @param tracker name of the tracker whose poses are used. @param sensor its sensor.
  VrpnStream(std::string tracker, std::int32_t sensor) : tracker_(std::move(tracker)), sensor_(sensor) {}

  /// @param use is called with each plausible pose of that sensor. @returns false: the stream is not VRPN.
  bool consume(std::span<const std::byte> bytes, const Use& use);
  std::uint64_t messages() const { return messages_; }
  /// The number of poses of other trackers or sensors, and of poses that have a fault (fault_of()).
  std::uint64_t passed_over() const { return passed_over_; }
  /// The senders, trackers among them, that the server has named, for a message about a wrong name.
  std::vector<std::string> senders() const;
  /// Why there is no pose: the server does not have the tracker, or no plausible pose of its sensor has arrived. The
  /// names in it are unchecked bytes of the server: print it through printable().
  std::string silence_reason() const;

 private:
  void take(std::span<const std::byte> message, const Use& use);
  void add_name(std::map<std::int32_t, std::string>& names, std::int32_t number, std::span<const std::byte> body);

  std::string tracker_;
  std::int32_t sensor_;
  std::vector<std::byte> waiting_;
  bool has_cookie_ = false;
  std::map<std::int32_t, std::string> senders_, types_;
  std::uint64_t messages_ = 0;
  std::uint64_t passed_over_ = 0;
};

}  // namespace m100::lab::bridge
