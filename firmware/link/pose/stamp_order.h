// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/core/pose.h"
#include "firmware/core/time.h"

namespace m100::link {

/// Decides from the time stamps whether a pose is newer than the last one, and whether the sender's clock was set.
///
/// A stamp that goes back has two possible causes: a newer pose has overtaken this one, or the sender's clock was set
/// back. A stamp in the future shows a clock that was set forward. Two poses with rising stamps that only a set clock
/// explains show a new clock. Without such certainty, poses with rising stamps are refused until three of them have
/// come over at least kMaxRefusal.
///
/// Cost: constant for a rising stamp, one pass over kRemembered stamps for another.
class StampOrder {
 public:
  static constexpr std::size_t kRemembered = 64;
  /// est::kMaxPoseAge_s less one period of a 20 Hz source: an overtaken pose that comes later is too old to be used.
  static constexpr core::Duration kMaxRefusal = std::chrono::milliseconds(200);
  static constexpr core::Duration kSenderGone = std::chrono::seconds(1);

  enum class Verdict : std::uint8_t {
    kRises,    ///< newer than the last, or the first
    kSet,      ///< newer, by a clock that was set
    kRefused,  ///< doubled, overtaken, or not yet known to be newer
  };

  /// @param frame the number of the pose's frame
  Verdict judge(core::SenderTime stamp, std::uint8_t frame, core::TimePoint now);
  /// Forgets all stamps: the next one is the first.
  void reset() { *this = StampOrder{}; }

 private:
  /// Refused poses whose stamps rise among themselves, since the last accepted pose.
  struct Run {
    std::uint32_t count = 0;
    std::uint32_t sure = 0;  ///< those of them that only a set clock explains
    core::SenderTime newest{};
    core::TimePoint newest_at{};
    core::TimePoint since{};
  };
  void begin(core::SenderTime stamp, core::TimePoint now);
  Verdict accept(core::SenderTime stamp, core::TimePoint now);
  void remember(core::SenderTime stamp);
  bool is_taken(core::SenderTime stamp) const;
  bool continues_run(core::SenderTime stamp, core::TimePoint now) const;
  Verdict refuse(core::SenderTime stamp, bool is_sure, core::TimePoint now);

  std::array<core::SenderTime, kRemembered> stamps_{};  ///< the last, in the order of arrival
  std::size_t count_ = 0;
  std::uint8_t newest_frame_ = 0;
  core::SenderTime newest_{};
  core::TimePoint newest_at_{};
  core::Duration offset_{0};                ///< least (arrival - stamp) of the last poses; follows a drift of 3 %
  core::SenderClock::duration spacing_{0};  ///< least rise of the stamps; follows a source that becomes slower
  Run run_;
};

}  // namespace m100::link
