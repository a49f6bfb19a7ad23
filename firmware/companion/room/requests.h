// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <variant>

#include "protocol/mavlink/frame.h"
#include "protocol/mavlink/mission_messages.h"
#include "protocol/mavlink/order_messages.h"

namespace m100::companion {

/// What a room may ask for beside goals and orders.
using RequestMessage =
    std::variant<mavlink::MissionCount, mavlink::MissionItem, mavlink::MissionItemInt, mavlink::MissionRequestList,
                 mavlink::MissionRequest, mavlink::MissionRequestInt, mavlink::MissionAck, mavlink::MissionClearAll,
                 mavlink::ParamRequestList, mavlink::ParamRequestRead, mavlink::ParamSet>;

/// And who asked.
struct Request {
  RequestMessage message;
  mavlink::Address from;
};

/// What a room is told in answer, or of its own accord.
using Reply =
    std::variant<mavlink::CommandAck, mavlink::MissionCount, mavlink::MissionItemInt, mavlink::MissionRequestInt,
                 mavlink::MissionAck, mavlink::MissionCurrent, mavlink::MissionItemReached, mavlink::ParamValue>;

/// A few of something, without heap. What finds no room is lost, as on the network.
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

/// Of one tick.
inline constexpr std::size_t kMostRequests = 8;
using Requests = BoundedList<Request, kMostRequests>;
/// At most one for each request, and what a tick says of its own accord.
using Replies = BoundedList<Reply, kMostRequests + 8>;

}  // namespace m100::companion
