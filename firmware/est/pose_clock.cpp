// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/pose_clock.h"

#include "firmware/core/maths.h"

namespace m100::est {
namespace {

constexpr double kMemory = 3000.0;  // poses
constexpr double kRise = 3e-4;      // of the time that has passed: three times the drift of a poor quartz
constexpr double kMostDrift = 0.02;
constexpr std::uint32_t kSlowerSource =
    4;                                  // steps in a row: chance does that once in 160000 where one in twenty is lost
constexpr double kLongest_s = 10.0;     // without a pose: begun anew
constexpr double kSetForward_s = 0.25;  // earlier than the envelope: no message is, so the sender's clock was set

core::Duration duration_of(double seconds) {
  return core::Duration(static_cast<core::Duration::rep>(seconds * 1e6 + (seconds < 0.0 ? -0.5 : 0.5)));
}

}  // namespace

void PoseClock::begin(core::SenderTime captured, core::TimePoint arrived) {
  *this = PoseClock{};
  origin_ = arrived;
  last_ = captured;
  count_ = 1;
}

void PoseClock::fit(double own_s, double arrived_s) {
  const double count = static_cast<double>(count_);
  const double share = 1.0 / (count < kMemory ? count : kMemory);
  const double apart = own_s - mean_own_s_;
  const double late = arrived_s - mean_s_;
  mean_own_s_ += share * apart;
  mean_s_ += share * late;
  square_ = (1.0 - share) * (square_ + share * apart * apart);
  product_ = (1.0 - share) * (product_ + share * apart * late);
  rate_ = core::clamp(square_ > 0.0 ? product_ / square_ : 1.0, 1.0 - kMostDrift, 1.0 + kMostDrift);
}

void PoseClock::note_spacing(double step_s) {
  if (spacing_s_ <= 0.0) {
    spacing_s_ = step_s;
    return;
  }
  // A step over captures that were lost counts little, so that some loss does not look like a slower source.
  const bool usual = step_s < 1.5 * spacing_s_;
  least_long_step_s_ = long_steps_ == 0 || step_s < least_long_step_s_ ? step_s : least_long_step_s_;
  long_steps_ = usual ? 0U : long_steps_ + 1U;
  if (long_steps_ >= kSlowerSource) {  // and not one step of the usual length between them: the source is slower now
    spacing_s_ = least_long_step_s_;
    long_steps_ = 0;
    return;
  }
  spacing_s_ += (usual ? 1.0 / 16.0 : 1.0 / 256.0) * (step_s - spacing_s_);
}

core::TimePoint PoseClock::note(core::SenderTime captured, core::TimePoint arrived) {
  const double arrived_s = core::seconds<double>(arrived - origin_);
  const double step_s = core::seconds<double>(core::Duration((captured - last_).count()));
  if (count_ == 0 || step_s <= 0.0 || step_s > kLongest_s) {
    begin(captured, arrived);
    return arrived;
  }
  last_ = captured;
  count_ += count_ < 1000000U ? 1U : 0U;
  own_s_ += step_s;
  note_spacing(step_s);
  const bool is_overdue = is_proven() && arrived_s - (envelope_s_ + step_s * rate_) > kMostLateness_s;
  if (!is_overdue) {
    fit(own_s_, arrived_s);
  }
  if (count_ < kSettled) {
    envelope_s_ = arrived_s;
    return arrived;
  }
  const double way_s = step_s * rate_;
  const double late_s = arrived_s - (envelope_s_ + way_s);
  if (late_s < -kSetForward_s) {
    begin(captured, arrived);
    return arrived;
  }
  // The rate is known to jitter / n^1.5 of a pose's step (least squares over n poses of that spread).
  const double count = static_cast<double>(count_);
  const double unsure_s = lateness_.value_s() * (step_s / spacing_s_) / (count * core::sqrt(count));
  const double rise_s = kRise * way_s + unsure_s;
  envelope_s_ += way_s + (late_s < rise_s ? late_s : rise_s);
  lateness_.note(late_s);
  if (!is_proven()) {
    in_time_ = late_s < kMostLateness_s ? in_time_ + 1 : 0;
  }
  return is_regular() ? origin_ + duration_of(envelope_s_) : arrived;
}

core::Duration PoseClock::interval() const { return count_ < kSettled ? core::Duration{0} : duration_of(spacing_s_); }

core::Duration PoseClock::lateness() const { return duration_of(lateness_.value_s()); }

}  // namespace m100::est
