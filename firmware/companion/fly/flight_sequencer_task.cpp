// SPDX-License-Identifier: BSD-3-Clause
// The parts of a flight that are the autopilot's own tasks: take-off before it, landing after it.
#include "firmware/companion/fly/flight_sequencer.h"
#include "firmware/companion/operator/operator_messages.h"

namespace m100::companion {

void FlightSequencer::begin_task(core::TimePoint now, protocol::Task task) {
  phase_ = Phase::kTask;
  task_.start(task, now);
  controller_.task_flies(task);
  TextLine line;
  report(
      now,
      line.add(name(task)).add(" ordered: the autopilot flies it as its own task; the pilot's switch ends it").text());
}

bool FlightSequencer::fly_task(core::TimePoint now, const View& view, const SequencerInput& input) {
  if (!view.in_control) {
    report_end(now, view);
    begin_release(now, false, input);
    return true;
  }
  if (input.stops > 0 || input.toggle_control) {
    controller_.release();
    begin_release(now, true, input);
    return true;
  }
  if (input.land && task_.task() == protocol::Task::kTakeOff) {
    begin_task(now, protocol::Task::kLand);
  }
  switch (task_.tick(now, controller_)) {
    case AutopilotTask::State::kDone:
      end_task(now, input);
      break;
    case AutopilotTask::State::kFailed: {
      TextLine line;
      describe(line, task_);
      report(now, line.add("; control goes back to the transmitter").text());
      controller_.release();
      begin_release(now, false, input);
      break;
    }
    default:
      break;
  }
  return true;
}

void FlightSequencer::end_task(core::TimePoint now, const SequencerInput& input) {
  if (task_.task() == protocol::Task::kLand) {
    landed_ = true;
    report(now, "landed: by the autopilot's flight status, the aircraft is on the ground");
    controller_.release();
    begin_release(now, true, input);
    return;
  }
  took_off_ = true;
  if (is_out_of_bounds(false)) {
    report_position(now, false);
    controller_.release();
    begin_release(now, false, input);
    return;
  }
  report(now, "taken off: by the autopilot's flight status, the aircraft is in the air; the law takes over");
  controller_.engage();
  phase_ = Phase::kFlying;
  since_ = now;  // --hold counts from where the law takes over
}

}  // namespace m100::companion
