// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/pose/clock_comparison.h"

namespace m100::link {
namespace {

constexpr std::int64_t kNsPerUs = 1000;
/// The error bound of an answer grows by a thousandth of the time since it came: ten times the drift of a poor quartz.
constexpr std::int64_t kAging = 1000;

std::int64_t ns_of(core::TimePoint at) { return at.time_since_epoch().count() * kNsPerUs; }
core::Duration distance(core::Duration a, core::Duration b) { return a > b ? a - b : b - a; }

}  // namespace

std::int64_t ClockComparison::request(core::TimePoint now) {
  asked_ = true;
  waiting_ = true;
  asked_at_ = now;
  return ns_of(now);
}

core::Duration ClockComparison::bound(core::TimePoint now) const {
  return half_ + core::Duration((now - found_at_).count() / kAging);
}

bool ClockComparison::answer(std::int64_t ts1, std::int64_t theirs, core::TimePoint arrived) {
  if (!waiting_ || ts1 != ns_of(asked_at_) || arrived < asked_at_ || arrived - asked_at_ > kLatest) {
    return false;
  }
  waiting_ = false;
  const core::Duration half = (arrived - asked_at_) / 2;
  const core::Duration to_ours = (asked_at_ + half).time_since_epoch() - core::Duration(theirs / kNsPerUs);
  const bool apart = known_ && distance(to_ours, to_ours_) > half + bound(arrived);  // the sender's clock was set
  if (!known_ || apart || half <= bound(arrived)) {
    known_ = true;
    to_ours_ = to_ours;
    half_ = half;
    found_at_ = arrived;
  }
  return true;
}

core::ClockOffset ClockComparison::offset(core::TimePoint now) const {
  return {.known = known_, .to_ours = to_ours_, .bound = known_ ? bound(now) : core::Duration{0}};
}

}  // namespace m100::link
