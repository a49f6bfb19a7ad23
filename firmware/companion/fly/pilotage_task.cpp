// SPDX-License-Identifier: BSD-3-Clause
// The parts of a flight that are the autopilot's own tasks: take-off before it, landing after it.
#include "firmware/companion/fly/pilotage.h"
#include "firmware/companion/fly/words.h"

namespace m100::companion {

void Pilotage::begin_task(core::TimePoint now, protocol::Task task) {
  phase_ = Phase::kTask;
  task_.order(task, now);
  controller_.task_flies(task);
  TextLine line;
  tell(now,
       line.add(name(task)).add(" ordered: the autopilot flies it as its own task; the pilot's switch ends it").text());
}

bool Pilotage::fly_task(core::TimePoint now, const View& view, const OperatorInput& input) {
  if (!view.in_control) {
    tell_end(now, view);
    begin_hand_back(now, false, input);
    return true;
  }
  if (input.stops > 0 || input.word) {
    controller_.release();
    begin_hand_back(now, true, input);
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
      tell(now, line.add("; control goes back to the transmitter").text());
      controller_.release();
      begin_hand_back(now, false, input);
      break;
    }
    default:
      break;
  }
  return true;
}

void Pilotage::end_task(core::TimePoint now, const OperatorInput& input) {
  if (task_.task() == protocol::Task::kLand) {
    landed_ = true;
    tell(now, "landed: by the autopilot's flight status, the aircraft is on the ground");
    controller_.release();
    begin_hand_back(now, true, input);
    return;
  }
  took_off_ = true;
  if (is_elsewhere(false)) {
    tell_place(now, false);
    controller_.release();
    begin_hand_back(now, false, input);
    return;
  }
  tell(now, "taken off: by the autopilot's flight status, the aircraft is in the air; the law takes over");
  controller_.engage();
  phase_ = Phase::kFlying;
  since_ = now;  // --hold counts from where the law takes over
}

}  // namespace m100::companion
