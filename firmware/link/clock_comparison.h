// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/pose.h"
#include "firmware/core/time.h"

namespace m100::link {

/// Compares our clock with that of the source of pose, by questions and answers (TIMESYNC). Each answer says that their
/// time was T somewhere between our question and its arrival: the offset is known to half of what there and back took,
/// and no better, whatever the two ways were. The best answer is kept until drift has made a newer one better.
class ClockComparison {
 public:
  static constexpr core::Duration kEvery = std::chrono::milliseconds(200);
  static constexpr core::Duration kLatest = std::chrono::milliseconds(500);  ///< there and back; a later answer is none

  /// @returns true: it is time to ask.
  bool due(core::TimePoint now) const { return !asked_ || since_asked(now) >= kEvery; }
  core::Duration since_asked(core::TimePoint now) const { return now - asked_at_; }
  /// An answer has come.
  bool is_known() const { return known_; }
  /// Notes a question that is sent now. @returns what stands in its ts1 [ns].
  std::int64_t ask(core::TimePoint now);
  /// An answer. @param ts1 that of its question; an answer to any other than the last is passed over.
  /// @param theirs their time [ns] @returns false: passed over.
  bool answer(std::int64_t ts1, std::int64_t theirs, core::TimePoint arrived);
  /// Their clock has begun anew.
  void forget() { *this = ClockComparison{}; }

  core::ClockOffset offset(core::TimePoint now) const;

 private:
  core::Duration bound(core::TimePoint now) const;

  bool asked_ = false;
  bool waiting_ = false;
  core::TimePoint asked_at_{};
  bool known_ = false;
  core::Duration to_ours_{0};
  core::Duration half_{0};
  core::TimePoint found_at_{};
};

}  // namespace m100::link
