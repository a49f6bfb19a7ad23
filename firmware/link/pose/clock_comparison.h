// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/pose.h"
#include "firmware/core/time.h"

namespace m100::link {

/// Compares our clock with that of the source of pose, by questions and answers (TIMESYNC). Each answer shows that the
/// sender's time was T at some moment between our question and the answer's arrival. The offset is therefore known to
/// half of the round trip and no better. The best answer is kept until a newer one is better or contradicts it.
class ClockComparison {
 public:
  static constexpr core::Duration kEvery = std::chrono::milliseconds(200);
  static constexpr core::Duration kLatest = std::chrono::milliseconds(500);  ///< round trip; a later answer is ignored

  /// Whether it is time for a question.
  bool due(core::TimePoint now) const { return !asked_ || since_request(now) >= kEvery; }
  core::Duration since_request(core::TimePoint now) const { return now - asked_at_; }
  /// Whether an answer has come.
  bool is_known() const { return known_; }
  /// Records a question that is sent now. @returns the value of its ts1 [ns].
  std::int64_t request(core::TimePoint now);
  /// Records an answer. @param ts1 that of its question; only an answer to the last question, within kLatest, counts.
  /// @param theirs the sender's time [ns]. @returns false: the answer is ignored.
  bool answer(std::int64_t ts1, std::int64_t theirs, core::TimePoint arrived);
  /// For another sender: forgets all answers.
  void reset() { *this = ClockComparison{}; }

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
