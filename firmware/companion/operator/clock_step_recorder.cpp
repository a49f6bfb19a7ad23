// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/operator/clock_step_recorder.h"

#include <utility>

#include "firmware/companion/operator/text_line.h"

namespace m100::companion {
namespace {

/// A slew is a series of small steps; after this time without one, it is over.
constexpr core::Duration kStepOver = std::chrono::milliseconds(500);
/// If the source is too irregular to show why its poses come later than before, a larger delay than this is reported.
constexpr core::Duration kLater = std::chrono::milliseconds(50);
/// Arrivals are known to one tick, so that an estimated step of less than half a tick counts as none.
constexpr core::Duration kMinStep = core::kTickPeriod / 2;

}  // namespace

void ClockStepRecorder::update(core::TimePoint now, const est::PoseTimingReport<double>& timing, OperatorLog& log) {
  if (timing.times_set != times_set_) {
    step_.at = step_is_open_ ? step_.at : now;
    step_.by += timing.set_by - set_by_;
    step_.lasted = now - step_.at;
    step_is_open_ = true;
    stepped_at_ = now;
    times_set_ = timing.times_set;
    set_by_ = timing.set_by;
  }
  if (timing.unexplained > kLater && !later_said_) {
    TextLine line;
    line.add("poses come ").add(core::seconds<double>(timing.unexplained), 2);
    line.add(
        " s later than before: the source's clock was set back, or their way takes longer; its stamps are too "
        "irregular to tell");
    log.write(now, line.text());
  }
  later_said_ = timing.unexplained > kLater;
  if (!step_is_open_ || now - stepped_at_ < kStepOver) {
    return;
  }
  const ClockStep step = std::exchange(step_, {});
  step_is_open_ = false;
  if (step.by < kMinStep && step.by > -kMinStep) {
    return;
  }
  TextLine line;
  const double by_s = core::seconds<double>(step.by);
  line.add("the source's clock was set by ").add(by_s > 0.0 ? "+" : "").add(by_s, 2).add(" s");
  if (step.lasted > core::Duration{0}) {
    line.add(", in ").add(core::seconds<double>(step.lasted), 1).add(" s");
  }
  log.write(now, line.text());
  if (step_count_ < steps_.size()) {
    steps_[step_count_++] = step;
  }
}

}  // namespace m100::companion
