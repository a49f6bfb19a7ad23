// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/operator/clock_step_recorder.h"

#include "firmware/companion/operator/text_line.h"

namespace m100::companion {
namespace {

/// A slew is a row of small steps; after this time without one, it is over.
constexpr core::Duration kStepOver = std::chrono::milliseconds(500);

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
  if (!step_is_open_ || now - stepped_at_ < kStepOver) {
    return;
  }
  TextLine line;
  const double by_s = core::seconds<double>(step_.by);
  line.add("the source's clock was set by ").add(by_s > 0.0 ? "+" : "").add(by_s, 2).add(" s");
  if (step_.lasted > core::Duration{0}) {
    line.add(", in ").add(core::seconds<double>(step_.lasted), 1).add(" s");
  }
  log.write(now, line.text());
  if (step_count_ < steps_.size()) {
    steps_[step_count_++] = step_;
  }
  step_ = {};
  step_is_open_ = false;
}

}  // namespace m100::companion
