// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/time.h"
#include "protocol/mavlink/frame.h"

namespace m100::link {

/// The sender of poses that the operator has chosen.
struct SenderChoice {
  std::uint8_t system = 0;     ///< 0: none was chosen
  std::uint8_t component = 0;  ///< 0: any of that system

  bool is_made() const { return system != 0; }
  bool admits(mavlink::Address from) const {
    return !is_made() || (from.system == system && (component == 0 || from.component == component));
  }
};

/// The first eight senders of poses on a line, whether their poses are used or not.
class PoseSenders {
 public:
  static constexpr std::size_t kMaxSenders = 8;
  static constexpr core::Duration kRecent = std::chrono::seconds(2);

  struct Sender {
    mavlink::Address from;
    std::uint64_t poses = 0;
    core::TimePoint first{};
    core::TimePoint last{};
    double rate_hz() const {
      const double lasted_s = core::seconds<double>(last - first);
      return lasted_s > 0.0 ? static_cast<double>(poses - 1) / lasted_s : 0.0;
    }
  };

  void add(mavlink::Address from, core::TimePoint now) {
    for (Sender& sender : std::span(senders_).first(count_)) {
      if (sender.from == from) {
        ++sender.poses;
        sender.last = now;
        return;
      }
    }
    if (count_ < kMaxSenders) {
      senders_[count_++] = {.from = from, .poses = 1, .first = now, .last = now};
    }
  }
  std::span<const Sender> all() const { return std::span(senders_).first(count_); }
  const Sender* find(mavlink::Address from) const {
    for (const Sender& sender : all()) {
      if (sender.from == from) {
        return &sender;
      }
    }
    return nullptr;
  }
  /// Another sender that has sent poses within kRecent. @returns null: none
  const Sender* other_than(mavlink::Address from, core::TimePoint now) const {
    for (const Sender& sender : all()) {
      if (sender.from != from && now - sender.last <= kRecent) {
        return &sender;
      }
    }
    return nullptr;
  }

 private:
  std::array<Sender, kMaxSenders> senders_{};
  std::size_t count_ = 0;
};

}  // namespace m100::link
