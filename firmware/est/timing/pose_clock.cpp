// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/timing/pose_clock.h"

#include "firmware/core/maths.h"

namespace m100::est {
namespace {

constexpr float kMemory = 3000.F;  // poses
constexpr float kRise = 3e-4F;     // rise of the envelope per elapsed time: three times the drift of a poor quartz
constexpr float kMaxDrift = 0.02F;
/// So many long steps in a row show a slower source. With one capture in twenty lost, that happens once in 160000.
constexpr std::uint32_t kSlowerSource = 4;
constexpr core::Duration kLongest = std::chrono::seconds(10);  // without a pose: restart
/// An uneven stamp that is earlier than the envelope by more than this shows that the clock was set: three ticks.
constexpr float kEarly_s = 3.F * core::seconds<float>(core::kTickPeriod);
constexpr float kUneven = 0.25F;  // in spacings: stamps that deviate more from whole captures may show a set clock

}  // namespace

void PoseClock::begin(core::SenderTime captured, core::TimePoint arrived) {
  const core::Duration set_by = set_by_;
  const std::uint32_t times_set = times_set_;
  *this = PoseClock{};
  set_by_ = set_by;
  times_set_ = times_set;
  last_arrived_ = arrived;
  last_ = captured;
  count_ = 1;
}

void PoseClock::set(core::Duration by) {
  set_by_ += by;
  ++times_set_;
}

/// Whether stamps that advanced by `step` while `gap` passed come from a clock that was set.
bool PoseClock::was_set(core::Duration step, core::Duration gap, const Context& context) const {
  if (step <= core::Duration{0} || step > kLongest) {
    return true;
  }
  if (count_ < kMinPoses) {
    return false;
  }
  const float step_s = core::seconds<float>(step);
  const float gap_s = core::seconds<float>(gap);
  const float early_s = step_s * (1.F + drift_) - gap_s - behind_s_;
  const float uneven_s = shift_.uneven_s(step_s, gap_s);
  const bool is_uneven = uneven_s * uneven_s > kUneven * kUneven * shift_.spacing_s() * shift_.spacing_s();
  return is_uneven && (early_s > kEarly_s || (context.clock_was_set && uneven_s < 0.F));
}

/// Corrects the estimate for a slew or step of the sender's clock that ClockShift has found.
void PoseClock::note_shift(const ClockShift::Step& step) {
  const float lost_s = shift_.update(step, lateness_.value_s());
  if (lost_s < 0.F || lost_s > 0.F) {
    slipped_s_ -= lost_s;
    behind_s_ -= lost_s > 0.F ? lost_s : 0.F;  // the envelope has followed a clock that gained time
    set(duration_of(-lost_s));
  }
}

/// Estimates the offset of the clocks anew; from kMinPoses on, what is known of rate, spacing and jitter stays.
void PoseClock::restart(core::SenderTime captured, core::TimePoint arrived) {
  if (count_ < kMinPoses) {
    begin(captured, arrived);
    return;
  }
  const float gap_s = core::seconds<float>(arrived - last_arrived_);
  const float between_s = shift_.is_regular() ? gap_s - shift_.uneven_s(gap_s, gap_s) : gap_s;
  set(core::Duration((captured - last_).count()) - duration_of(between_s));
  last_ = captured;
  last_arrived_ = arrived;
  behind_s_ = 0.F;
}

void PoseClock::lose(core::Duration lost) {
  const float lost_s = core::seconds<float>(lost);
  if (count_ < kMinPoses || behind_s_ < 0.5F * lost_s) {
    return;  // already known
  }
  slipped_s_ -= lost_s;
  behind_s_ = behind_s_ > lost_s ? behind_s_ - lost_s : 0.F;
  set(-lost);
}

/// Updates the least squares by the last pose; own_s_ and slipped_s_ already include its step.
void PoseClock::fit() {
  const float count = static_cast<float>(count_);
  const float share = 1.F / (count < kMemory ? count : kMemory);
  const float kept = 1.F - share;
  square_ = kept * (square_ + share * own_s_ * own_s_);
  product_ = kept * (product_ + share * own_s_ * slipped_s_);
  own_s_ *= kept;
  slipped_s_ *= kept;
  drift_ = core::clamp(square_ > 0.F ? product_ / square_ : 0.F, -kMaxDrift, kMaxDrift);
}

void PoseClock::update_interval(float step_s) {
  if (spacing_s_ <= 0.F) {
    spacing_s_ = step_s;
    return;
  }
  // A step much longer than usual has a small weight, because it may span lost captures of an unchanged source.
  const bool usual = step_s < 1.5F * spacing_s_;
  min_long_step_s_ = long_steps_ == 0 || step_s < min_long_step_s_ ? step_s : min_long_step_s_;
  long_steps_ = usual ? 0U : long_steps_ + 1U;
  if (long_steps_ >= kSlowerSource) {  // without a step of the usual length between them: the source is slower now
    spacing_s_ = min_long_step_s_;
    long_steps_ = 0;
    return;
  }
  spacing_s_ += (usual ? 1.F / 16.F : 1.F / 256.F) * (step_s - spacing_s_);
}

core::TimePoint PoseClock::update(core::SenderTime captured, core::TimePoint arrived, const Context& context) {
  const core::Duration step((captured - last_).count());
  const core::Duration gap = arrived - last_arrived_;
  if (count_ == 0 || gap > kLongest) {
    begin(captured, arrived);
    return arrived;
  }
  if (was_set(step, gap, context)) {
    restart(captured, arrived);
    return arrived;
  }
  const float step_s = core::seconds<float>(step);
  const float slip_s = core::seconds<float>(gap - step);
  last_ = captured;
  last_arrived_ = arrived;
  count_ += count_ < 1000000U ? 1U : 0U;
  own_s_ += step_s;
  slipped_s_ += slip_s;
  update_interval(step_s);
  note_shift({step_s, slip_s - step_s * drift_, static_cast<float>(context.poses)});
  const float late_so_far_s = behind_s_ + slip_s;  // relative to an envelope that does not drift
  const bool is_overdue = is_proven() && late_so_far_s - step_s * drift_ > kMaxLateness_s;
  if (!is_overdue) {
    fit();
  }
  if (count_ < kMinPoses) {
    behind_s_ = 0.F;
    return arrived;
  }
  const float late_s = late_so_far_s - step_s * drift_;
  // Uncertainty of the rate per pose step: jitter / n^1.5 (least squares over n poses of that spread).
  const float count = static_cast<float>(count_);
  const float unsure_s = lateness_.value_s() * (step_s / spacing_s_) / (count * core::sqrt(count));
  const float rise_s = kRise * step_s * (1.F + drift_) + unsure_s;
  behind_s_ = late_s < rise_s ? 0.F : late_s - rise_s;
  lateness_.update(late_s);
  if (!is_proven()) {
    in_time_ = late_s < kMaxLateness_s ? in_time_ + 1 : 0;
  }
  return is_regular() ? arrived - duration_of(behind_s_) : arrived;
}

core::Duration PoseClock::interval() const { return count_ < kMinPoses ? core::Duration{0} : duration_of(spacing_s_); }

core::Duration PoseClock::lateness() const { return duration_of(lateness_.value_s()); }

}  // namespace m100::est
