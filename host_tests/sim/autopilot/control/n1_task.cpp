// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/autopilot/control/n1_task.h"

#include "protocol/dji/acks.h"

namespace m100::sim {
namespace {

constexpr core::Duration kFinishingLanding = std::chrono::seconds(2);  // protocol, 8

}  // namespace

std::uint16_t N1Task::start(const protocol::TaskRequest& request, bool client_in_control) {
  const bool take_off = request.task == protocol::Task::kTakeOff;
  const VehicleState& state = vehicle_.state();
  const bool fits = take_off ? !state.in_air && !state.motors_on : state.in_air;  // protocol, 6.3: motors stopped
  log_.emit("received", take_off                                ? "task_takeoff"
                        : request.task == protocol::Task::kLand ? "task_land"
                                                                : "task_go_home");
  if (!client_in_control || behaviour_ == 0.0 || !how_.offered || !fits) {
    return protocol::task_ack::kRefused;
  }
  if (behaviour_ == 2.0) {
    return protocol::task_ack::kStarted;
  }
  task_ = request.task;
  number_ = request.sequence;
  open_ = true;
  done_ = false;
  if (take_off) {
    vehicle_.set_motors(true);
  }
  return protocol::task_ack::kStarted;
}

std::uint16_t N1Task::result(const protocol::TaskQuery& query) const {
  if (task_ == protocol::Task{} || query.sequence != number_) {
    return protocol::task_query_ack::kWrongNumber;
  }
  if (done_) {
    return protocol::task_query_ack::kSucceeded;
  }
  return open_ ? protocol::task_query_ack::kInProgress : protocol::task_query_ack::kFailed;
}

MovementInput N1Task::fly() {
  const VehicleState& state = vehicle_.state();
  const bool climbing = task_ == protocol::Task::kTakeOff;
  done_ = climbing ? state.position_w_m.z() >= how_.take_off_height_m : !state.in_air;
  if (behaviour_ == 3.0) {  // endless: begun, but without effect
    done_ = false;
    return {};
  }
  if (!done_) {
    return {.climb_m_s = climbing ? how_.take_off_climb_m_s : -how_.landing_sink_m_s};
  }
  log_.emit("did", climbing ? "taken_off" : "landed");
  if (!climbing) {
    vehicle_.set_motors(false);
    landed_at_ = log_.now();
    open_ = false;
  }
  return {};
}

void N1Task::end() {
  if (in_progress()) {
    log_.emit("did", "task_ended");
  }
  open_ = false;
}

void N1Task::restart() {
  task_ = {};
  open_ = done_ = false;
  landed_at_ = {};
}

protocol::FlightStatus N1Task::flight_status() const {
  if (in_progress()) {
    return task_ == protocol::Task::kTakeOff ? protocol::FlightStatus::kTakingOff : protocol::FlightStatus::kLanding;
  }
  if (landed_at_ != core::TimePoint{} && log_.now() - landed_at_ < kFinishingLanding && !vehicle_.state().in_air) {
    return protocol::FlightStatus::kLanded;
  }
  return vehicle_.state().in_air ? protocol::FlightStatus::kInAir : protocol::FlightStatus::kStandby;
}

}  // namespace m100::sim
