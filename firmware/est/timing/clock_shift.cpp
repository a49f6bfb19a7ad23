// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/timing/clock_shift.h"

#include "firmware/core/maths.h"

namespace m100::est {
namespace {

/// Smallest shift that is detected: half of a tick. The arrivals are known to one tick.
constexpr float kMinShift_s = 0.005F;
constexpr float kShareOfSpread = 0.25F;     // the smallest of eight jitters is a ninth of the spread on average
constexpr float kAnotherRate = 4.F;         // a deficit of so many detectable shifts is no noise of one window
constexpr float kForgets = 1.F / 32.F;      // share of a shift forgotten per window: a quartz drifts 0.3 ms in 32
constexpr float kAdapts = 1.F / 64.F;       // weight of a window in the spacing
constexpr float kUneven = 1.F / 64.F;       // weight of a step in the mean square
constexpr float kLargestUneven = 0.25F;     // most that one step counts, in spacings
constexpr float kRegular = 0.125F;          // largest rms, in spacings: clocks are slewed by at most a tenth
constexpr float kLargestCaptures = 1000.F;  // in one step

float size(float value) { return value < 0.F ? -value : value; }

}  // namespace

/// Number of captures in `step_s`, rounded, 1 to kLargestCaptures.
float ClockShift::captures(float step_s) const {
  const float many = step_s / spacing_s_ + 0.5F;
  const float bounded = many < kLargestCaptures ? many : kLargestCaptures;
  return bounded < 2.F ? 1.F : static_cast<float>(static_cast<std::uint32_t>(bounded));
}

bool ClockShift::is_regular() const {
  return learnt_ >= kLearns && uneven_s2_ < kRegular * kRegular * spacing_s_ * spacing_s_;
}

/// Learns the spacing from steps without a lost capture, which are the shortest.
void ClockShift::learn(const Step& step) {
  ++learnt_;
  const float spacing_s = step.stamps_s / step.poses;
  if (spacing_s_ <= 0.F || spacing_s < (1.F - kLargestUneven) * spacing_s_) {
    spacing_s_ = spacing_s;
  } else if (spacing_s < (1.F + kLargestUneven) * spacing_s_) {
    spacing_s_ += (spacing_s - spacing_s_) / static_cast<float>(learnt_);
  }
}

float ClockShift::update(const Step& step, float spread_s) {
  if (learnt_ < kLearns) {
    learn(step);
    return 0.F;
  }
  const float counted = captures(step.stamps_s);
  const float captures = step.poses > counted ? step.poses : counted;
  const float uneven_s = step.stamps_s - captures * spacing_s_;
  const float each_s = uneven_s / captures;
  const float most_s = kLargestUneven * spacing_s_;
  const float counted_s = size(each_s) < most_s ? each_s : most_s;
  uneven_s2_ += kUneven * (counted_s * counted_s - uneven_s2_);
  shift_s_ += step.slip_s;
  deficit_s_ -= uneven_s;
  stamps_s_ += step.stamps_s;
  captures_ += captures;
  if (poses_ == 0 || shift_s_ < least_shift_s_) {
    least_shift_s_ = shift_s_;
    deficit_at_least_s_ = deficit_s_;
  }
  if (++poses_ < kWindow) {
    return 0.F;
  }
  const float lost_s = judge(spread_s);
  poses_ = 0;
  stamps_s_ = 0.F;
  captures_ = 0.F;
  return lost_s;
}

float ClockShift::judge(float spread_s) {
  const float shift_s = least_shift_s_;
  const float deficit_s = deficit_at_least_s_;
  if (!has_window_) {
    has_window_ = true;
    shift_s_ -= shift_s;
    deficit_s_ = 0.F;
    return 0.F;
  }
  const float share_s = kShareOfSpread * spread_s;
  const float seen_s = share_s > kMinShift_s ? share_s : kMinShift_s;
  unexplained_s_ = shift_s > seen_s && !is_regular() ? shift_s : 0.F;
  if (size(shift_s) > seen_s) {
    if (is_regular() && size(shift_s - deficit_s) < 0.5F * size(shift_s)) {
      shift_s_ -= deficit_s;
      deficit_s_ -= deficit_s;
      return deficit_s;
    }
  } else if (size(deficit_s) > kAnotherRate * seen_s) {  // stamps and arrivals agree: the source's rate has changed
    spacing_s_ = stamps_s_ / captures_;
    deficit_s_ = 0.F;
  } else if (size(deficit_s) < seen_s) {
    spacing_s_ += kAdapts * (stamps_s_ / captures_ - spacing_s_);
  }
  shift_s_ -= kForgets * shift_s;
  deficit_s_ -= kForgets * deficit_s;
  return 0.F;
}

}  // namespace m100::est
