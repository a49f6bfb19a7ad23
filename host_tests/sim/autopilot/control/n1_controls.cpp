// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/autopilot/control/n1_controls.h"

#include "protocol/dji/acks.h"
#include "protocol/dji/pushes.h"

namespace m100::sim {

N1Controls::N1Controls(const N1EventLog& log, N1Line& line, N1ClientRecord& record, VehiclePort& vehicle,
                       const Config& config)
    : log_(log),
      line_(line),
      record_(record),
      vehicle_(vehicle),
      how_(config.behaviour),
      authority_(log, how_.control, config.mode),
      virtual_rc_(log, record, how_.virtual_rc),
      task_(log, vehicle, how_.tasks),
      transmitter_(log, config.pilot_holds_position) {}

std::uint16_t N1Controls::request_control(bool obtain) {
  log_.emit("received", obtain ? "obtain_control" : "release_control");
  if (obtain) {
    record_.count_obtain_request();
  }
  const bool was_client = authority_.client_in_control();
  const std::uint16_t code = obtain ? authority_.obtain() : authority_.release();
  if (was_client == authority_.client_in_control()) {
    return code;
  }
  if (!obtain) {
    movement_.stop();
    task_.end_with_control();
  }
  record_.clear_loss();
  log_.emit("did", obtain ? "obtained" : "released");
  return code;
}

std::uint16_t N1Controls::switch_motors(bool start) {
  if (!authority_.client_in_control()) {
    return protocol::motor_ack::kNeedsControl;
  }
  const VehicleState& state = vehicle_.state();
  if (state.motors_on == start) {
    return protocol::motor_ack::kAlready;
  }
  if (state.in_air) {
    return protocol::motor_ack::kInAir;
  }
  vehicle_.set_motors(start);
  return protocol::motor_ack::kDone;
}

void N1Controls::switch_virtual_rc(const protocol::VirtualRcSwitch& wanted) {
  log_.emit("received", "vrc_switch", wanted.on ? 1.0 : 0.0);
  if (wanted.on && record_.count_virtual_rc_on_request()) {
    authority_.ignore_switch_until(log_.now() + N1ClientRecord::kSwitchSpacing);
  }
  virtual_rc_.switch_to(wanted,
                        authority_.rc_in_f() && (!how_.virtual_rc.needs_control || authority_.client_in_control()));
}

void N1Controls::set_movement(const protocol::Movement& movement) {
  record_.count_movement_frame(authority_.client_in_control());
  if (!authority_.client_in_control() ||
      protocol::check(movement) != core::Status::kOk) {  // also a mode that does not exist
    ++record_.counts().movement_ignored;
    log_.emit("ignored", "movement", movement.flag);
    return;
  }
  ++record_.counts().movement_taken;
  movement_.set(movement, vehicle_.state(), log_.now());
  log_.emit("received", "movement", movement.flag);
}

void N1Controls::drop_control(std::string_view why, protocol::ControlDevice now_in_control) {
  const bool was_client = authority_.client_in_control();
  record_.count_loss(was_client || virtual_rc_.is_on());
  authority_.drop(now_in_control);
  movement_.stop();
  task_.end_with_control();
  if (was_client) {
    log_.emit("did", why);
    if (!how_.control.lost_push) {
      return;
    }
    const core::Expected<protocol::Value> value = encode(protocol::ControlLost{});
    line_.push(protocol::ids::kControlLost, *value, log_.now());
  }
}

void N1Controls::take_control(bool mobile) {
  authority_.set_mobile_wants_control(mobile);
  drop_control(mobile ? "taken_by_mobile" : "taken_by_rc",
               mobile ? protocol::ControlDevice::kMobileApp : protocol::ControlDevice::kRemoteController);
  end_virtual_rc("taken");
}

void N1Controls::end_virtual_rc(std::string_view why) {
  if (virtual_rc_.end(why) && how_.virtual_rc.end_gives_control_back) {
    drop_control("virtual_rc_ended", protocol::ControlDevice::kRemoteController);
  }
}

void N1Controls::switch_transmitter(bool on) {
  authority_.switch_rc(on);
  log_.emit("did", on ? "rc_on" : "rc_off");
  if (!on) {
    drop_control("rc_off", protocol::ControlDevice::kRemoteController);
  }
}

void N1Controls::restart() {
  record_.count_loss(authority_.client_in_control() || virtual_rc_.is_on());
  authority_.restart();
  virtual_rc_.restart();
  movement_.stop();
  task_.restart();
}

void N1Controls::update_mode() {
  const bool was_client = authority_.client_in_control();
  if (authority_.update_mode()) {
    if (how_.virtual_rc.leaving_f_ends_it) {
      end_virtual_rc("left_f");
    }
    drop_control("left_f", protocol::ControlDevice::kRemoteController);
  } else if (!was_client && authority_.client_in_control()) {
    record_.clear_loss();  // it returned with F
  }
}

MovementInput N1Controls::movement_input() const {
  const MovementInput input = movement_.input(vehicle_.state());
  return {.roll_rad = how_.movement.roll_sign * input.roll_rad,
          .pitch_rad = how_.movement.pitch_sign * input.pitch_rad,
          .climb_m_s = how_.movement.climb_sign * input.climb_m_s,
          .yaw_rate_rad_s = how_.movement.yaw_sign * input.yaw_rate_rad_s};
}

void N1Controls::update() {
  update_mode();
  if (const std::string_view why = virtual_rc_.late(); !why.empty()) {
    end_virtual_rc(why);
  }
  transmitter_.update(transmitter_in_control(), vehicle_.state());
  if (movement_.expire(log_.now(), duration_of_seconds(how_.movement.timeout_s))) {
    log_.emit("did", "movement_timed_out");
    if (how_.movement.timeout_gives_control_back) {
      drop_control("movement_timed_out", protocol::ControlDevice::kRemoteController);
    }
  }
  if (task_.in_progress()) {
    vehicle_.command(task_.fly());
  } else if (virtual_rc_.is_on()) {
    vehicle_.command(virtual_rc_.sticks());
  } else if (movement_.is_active()) {
    vehicle_.command(movement_input());
  } else if (authority_.client_in_control()) {
    vehicle_.command(MovementInput{});  // hovers by its own attitude hold, which has the right trim
  } else {
    vehicle_.command(transmitter_.sticks());
  }
}

void N1Controls::report(protocol::Telemetry& telemetry) const {
  telemetry.rc = virtual_rc_.is_on() && how_.virtual_rc.shown_in_rc_item ? virtual_rc_.rc_item()
                 : authority_.rc_is_on() ? transmitter_.rc_item(rc_mode(authority_.wanted_mode()))
                                         : protocol::Telemetry::Rc{};
  telemetry.flight_status = task_.flight_status();
  telemetry.control.mode = movement_.is_active() ? movement_.control_mode() : std::uint8_t{0};
  telemetry.control.bits =
      static_cast<std::uint8_t>(static_cast<unsigned>(authority_.device()) | (authority_.client_requested() ? 8U : 0U) |
                                (virtual_rc_.is_on() ? 16U : 0U));
}

}  // namespace m100::sim
