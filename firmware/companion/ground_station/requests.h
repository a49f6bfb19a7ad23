// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <variant>

#include "protocol/mavlink/command_messages.h"
#include "protocol/mavlink/frame.h"
#include "protocol/mavlink/mission_messages.h"

namespace m100::companion {

/// Requests that a ground station may send in addition to goals and orders.
using RequestMessage =
    std::variant<mavlink::MissionCount, mavlink::MissionItem, mavlink::MissionItemInt, mavlink::MissionRequestList,
                 mavlink::MissionRequest, mavlink::MissionRequestInt, mavlink::MissionAck, mavlink::MissionClearAll,
                 mavlink::ParamRequestList, mavlink::ParamRequestRead, mavlink::ParamSet>;

struct Request {
  RequestMessage message;
  mavlink::Address from;
};

/// Messages to the ground station: answers and notifications.
using Reply =
    std::variant<mavlink::CommandAck, mavlink::MissionCount, mavlink::MissionItemInt, mavlink::MissionRequestInt,
                 mavlink::MissionAck, mavlink::MissionCurrent, mavlink::MissionItemReached, mavlink::ParamValue>;

/// A list of fixed capacity, without heap. An element that finds no room is lost, as on the network.
template <typename Value, std::size_t kCapacity>
class BoundedList {
 public:
  /// @returns false: there is no room.
  bool add(const Value& value) {
    if (size_ == kCapacity) {
      return false;
    }
    values_[size_++] = value;
    return true;
  }
  std::span<const Value> all() const { return std::span(values_).first(size_); }
  void clear() { size_ = 0; }

 private:
  std::array<Value, kCapacity> values_{};
  std::size_t size_ = 0;
};

/// The requests of one tick.
inline constexpr std::size_t kMaxRequests = 8;
using Requests = BoundedList<Request, kMaxRequests>;
/// At most one reply for each request, and the notifications of a tick.
using Replies = BoundedList<Reply, kMaxRequests + 8>;

}  // namespace m100::companion
