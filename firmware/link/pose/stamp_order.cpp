// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/pose/stamp_order.h"

#include <algorithm>

namespace m100::link {
namespace {

/// A pose that arrives by this much too early for its stamp has a stamp in the future: arrivals are known to a tick,
/// and the earliest may be a tick late.
constexpr core::Duration kEarly = 3 * core::kTickPeriod;
constexpr core::Duration::rep kDriftParts = 33;  ///< offset_ may grow by 1 / 33 of the time: a drift of 3 %
/// For each rising stamp the estimated spacing may grow by 1 / kSpacingMemory. With overtaking, at worst one rise in
/// three is of one spacing. The chance that none of 74 is, which makes the estimate a third too large, is below 1e-12.
constexpr core::SenderClock::duration::rep kSpacingMemory = 256;

core::Duration way(core::SenderTime stamp, core::TimePoint now) {
  return now.time_since_epoch() - core::Duration(stamp.time_since_epoch().count());
}

}  // namespace

void StampOrder::begin(core::SenderTime stamp, core::TimePoint now) {
  const std::uint8_t frame = newest_frame_;
  reset();
  newest_frame_ = frame;
  remember(stamp);
  newest_ = stamp;
  newest_at_ = now;
  offset_ = way(stamp, now);
}

void StampOrder::remember(core::SenderTime stamp) { stamps_[count_++ % kRemembered] = stamp; }

/// @returns true: no overtaken pose can have this stamp. A pose with this stamp has come, or the stamps on both sides
///   of it are too close for another one between them, or it lies before all kRemembered.
bool StampOrder::is_taken(core::SenderTime stamp) const {
  using Step = core::SenderClock::duration;
  const std::size_t known = std::min(count_, kRemembered);
  Step below = Step::max(), above = Step::max();
  for (std::size_t i = 0; i < known; ++i) {
    const Step step = stamps_[i] - stamp;
    below = step <= Step{0} ? std::min(below, -step) : below;
    above = step >= Step{0} ? std::min(above, step) : above;
  }
  if (below == Step{0}) {
    return true;
  }
  if (below == Step::max()) {  // before all that are remembered
    return known == kRemembered;
  }
  return above != Step::max() && below + above < spacing_ + spacing_ / 2;
}

bool StampOrder::continues_run(core::SenderTime stamp, core::TimePoint now) const {
  return run_.count > 0 && stamp > run_.newest && way(stamp, now) >= way(run_.newest, run_.newest_at) - kEarly;
}

StampOrder::Verdict StampOrder::accept(core::SenderTime stamp, core::TimePoint now) {
  const bool was_set = run_.sure > 0 && continues_run(stamp, now);
  const core::Duration risen = offset_ + (now - newest_at_) / kDriftParts;
  offset_ = std::min(way(stamp, now), risen);
  const core::SenderClock::duration rise = stamp - newest_;
  spacing_ = spacing_ > core::SenderClock::duration{0} ? std::min(rise, spacing_ + spacing_ / kSpacingMemory) : rise;
  newest_ = stamp;
  newest_at_ = now;
  run_ = {};
  remember(stamp);
  return was_set ? Verdict::kSet : Verdict::kRises;
}

StampOrder::Verdict StampOrder::refuse(core::SenderTime stamp, bool is_sure, core::TimePoint now) {
  const bool continues = continues_run(stamp, now);
  if (run_.count > 0 && stamp <= run_.newest && !is_sure) {
    return Verdict::kRefused;  // doubled, or overtaken in the run
  }
  run_ = {.count = continues ? run_.count + 1 : 1U,
          .sure = (continues ? run_.sure : 0U) + (is_sure ? 1U : 0U),
          .newest = stamp,
          .newest_at = now,
          .since = continues ? run_.since : now};
  if (run_.sure >= 2 || (run_.count > 2 && now - run_.since >= kMaxRefusal)) {
    begin(stamp, now);
    return Verdict::kSet;
  }
  return Verdict::kRefused;
}

StampOrder::Verdict StampOrder::judge(core::SenderTime stamp, std::uint8_t frame, core::TimePoint now) {
  constexpr std::uint8_t kLargestStep = 127;
  const auto step = static_cast<std::uint8_t>(frame - newest_frame_);
  const bool is_later_frame = step >= 1 && step <= kLargestStep;
  newest_frame_ = is_later_frame || count_ == 0 ? frame : newest_frame_;
  if (count_ == 0 || now - newest_at_ > kSenderGone) {
    const bool was_set = count_ > 0 && stamp <= newest_;
    begin(stamp, now);
    newest_frame_ = frame;
    return was_set ? Verdict::kSet : Verdict::kRises;
  }
  const bool is_early = way(stamp, now) < offset_ - kEarly;
  if (stamp > newest_ && !is_early) {
    return accept(stamp, now);
  }
  const bool is_sure = is_early || (is_later_frame && is_taken(stamp));
  const Verdict verdict = refuse(stamp, is_sure, now);
  if (verdict == Verdict::kRefused && !is_sure && stamp < newest_) {
    remember(stamp);  // overtaken
  }
  return verdict;
}

}  // namespace m100::link
