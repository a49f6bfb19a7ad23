// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/autopilot/n1_autopilot.h"

#include <algorithm>
#include <cmath>

#include "host_tests/sim/autopilot/n1_script_syntax.h"
#include "protocol/dji/acks.h"
#include "protocol/dji/frame_encoder.h"
#include "protocol/dji/pushes.h"

// The autopilot's core: time, line, scripted events, commands to the aircraft. Unrequested messages are in
// n1_pushes.cpp, answered commands in n1_commands.cpp, commands without an answer in n1_channels.cpp.
namespace m100::sim {
namespace {

core::Duration duration_of(double seconds) { return core::Duration{std::llround(seconds * 1e6)}; }

/// The assistant's rates, with this one in place of its 50 Hz.
N1Rates with_rate(N1Rates rates, double rate_hz) {
  const protocol::Rate rate = rate_hz == 1.0    ? protocol::Rate::k1Hz
                              : rate_hz == 10.0 ? protocol::Rate::k10Hz
                              : rate_hz == 50.0 ? protocol::Rate::k50Hz
                                                : protocol::Rate::k100Hz;
  std::replace(rates.begin(), rates.end(), protocol::Rate::k50Hz, rate);
  return rates;
}

constexpr std::int64_t kTicksPerSlot = 4;  // telemetry slots of 10 ms

/// The event name of a script word. Empty for the remote controller, a restart, the sticks and a mode that changes:
/// these report themselves, with their effect.
std::string_view word_of(N1EventKind what, double value, N1Mode mode) {
  if (what == N1EventKind::kRc || what == N1EventKind::kRestart ||
      (what == N1EventKind::kMode && static_cast<N1Mode>(static_cast<char>(value)) != mode)) {
    return "";
  }
  if (what == N1EventKind::kTake) {
    return static_cast<char>(value) == 'm' ? "take_mobile" : "take_rc";
  }
  const auto* const form =
      std::find_if(kN1Events.begin(), kN1Events.end(), [&](const N1EventSyntax& one) { return one.what == what; });
  return form == kN1Events.end() ? "" : form->name;
}

}  // namespace

N1Autopilot::N1Autopilot(hal::Uart& uart, VehiclePort& vehicle, const N1Config& config)
    : vehicle_(vehicle),
      config_(config),
      line_(uart, config.baud, config.seed),
      random_(config.seed, "n1_autopilot"),
      estimator_(config.noise, config.seed),
      mode_(config.mode),
      wanted_mode_(config.mode),
      rates_(with_rate(config.rates, config.behaviour.telemetry.rate_hz)) {}

void N1Autopilot::emit(std::string_view what, std::string_view name, double value) const {
  if (sink_) {
    sink_({.at = time_, .what = what, .name = name, .value = value});
  }
}

void N1Autopilot::advance(core::TimePoint now) {
  while (ticks_next() <= now) {
    const core::TimePoint before = time_;
    time_ = ticks_next();
    ++ticks_;
    step(time_ - before);
  }
}

core::TimePoint N1Autopilot::tick_time(std::int64_t tick) const {
  const double own_us = static_cast<double>(tick * kTick.count());
  return core::TimePoint(core::Duration(std::llround(own_us / (1.0 + 1e-6 * config_.clock_drift_ppm))));
}

void N1Autopilot::step(core::Duration passed) {
  while (next_line_ < config_.script.size() && time_ >= config_.script[next_line_].at) {
    happen(config_.script[next_line_]);
    ++next_line_;
  }
  receive();
  if (mode_ != wanted_mode_ && time_ >= switch_ignored_until_) {
    set_real_mode(wanted_mode_);
  }
  if (virtual_rc_on_ && time_ - last_virtual_rc_ > duration_of(config_.behaviour.virtual_rc.timeout_s)) {
    end_virtual_rc(virtual_rc_falls_back_ ? "virtual_rc_silent" : "virtual_rc_silent_failsafe");
  }
  watch_transmitter();
  command_vehicle();
  vehicle_.advance(passed);
  if (time_ >= off_until_) {
    const bool speaks = activated_ || config_.behaviour.telemetry.before_activation;
    if (speaks && (ticks_ - booted_at_tick_) % kTicksPerSlot == 0) {
      send_telemetry();
    }
    line_.pump(time_);
  }
}

void N1Autopilot::receive() {
  // One read returns few bytes when the line is paced; eight reads take all that have arrived.
  for (int visit = 0; visit < 8; ++visit) {
    const std::span<const std::byte> bytes = line_.read(time_);
    if (bytes.empty()) {
      return;
    }
    if (time_ >= off_until_) {
      parser_.consume(bytes, [this](const protocol::FrameView& frame) {
        if (!line_.loses_incoming()) {
          handle(frame);
        }
      });
    }
  }
}

void N1Autopilot::happen(const N1ScriptLine& line) {
  if (line.what == N1EventKind::kStick) {
    emit("did", "stick", line.move.counts);
    pilot_.move(line.move);
  } else if (line.what == N1EventKind::kSensorFault) {
    emit("did", line.fault->name, line.value);
    start_sensor_fault(*line.fault, line.value);
  } else {
    happen(line.what, line.value, line.request);
  }
}

void N1Autopilot::happen(N1EventKind what, double value, N1Request request) {
  if (const std::string_view word = word_of(what, value, mode_); !word.empty()) {
    emit("did", word, what == N1EventKind::kMode ? rc_mode(mode_) : value);
  }
  switch (what) {
    case N1EventKind::kMode:
      wanted_mode_ = static_cast<N1Mode>(static_cast<char>(value));
      break;
    case N1EventKind::kRc:
      switch_rc(value != 0.0);
      break;
    case N1EventKind::kTake:
      take_control(static_cast<char>(value) == 'm');
      break;
    case N1EventKind::kRestart:
      restart();
      break;
    case N1EventKind::kSilence:
      silent_until_ = time_ + core::Duration{std::llround(value * 1e6)};
      break;
    case N1EventKind::kLoseAcks:
      acks_to_lose_ = static_cast<std::uint32_t>(value);
      acks_to_lose_of_ = request;
      break;
    case N1EventKind::kDelayAcks:
      ack_delay_ = core::Duration{std::llround(value * 1e6)};
      break;
    case N1EventKind::kDoubleAcks:
      acks_to_double_ = static_cast<std::uint32_t>(value);
      break;
    case N1EventKind::kNoise:
      line_.make_noise(static_cast<std::size_t>(value));
      break;
    case N1EventKind::kLoss:
      line_.set_loss(value);
      break;
    case N1EventKind::kIoc:
      ioc_ = value != 0.0;
      break;
    case N1EventKind::kActivation:
      forced_activation_ = static_cast<std::uint16_t>(value);
      break;
    case N1EventKind::kTasks:
      tasks_ = value;
      break;
    case N1EventKind::kEndTask:
      end_task();
      break;
    case N1EventKind::kPose:
      pose_on_ = value != 0.0;
      break;
    case N1EventKind::kEndVirtualRc:
      end_virtual_rc("ended_by_script");
      break;
    case N1EventKind::kStick:
    case N1EventKind::kSensorFault:
      break;  // these need the stick movement or the sensor fault of a script line
  }
}

void N1Autopilot::set_real_mode(N1Mode mode) {
  mode_ = mode;
  emit("did", "mode", rc_mode(mode));
  if (mode != N1Mode::kF) {
    requested_once_ = false;
    release_requested_once_ = false;
    lost_by_mode_ = lost_by_mode_ || client_in_control();
    if (config_.behaviour.virtual_rc.leaving_f_ends_it) {
      end_virtual_rc("left_f");
    }
    drop_control("left_f", protocol::ControlDevice::kRemoteController);
  } else if (lost_by_mode_ && config_.behaviour.control.returns_with_mode_f) {
    lost_by_mode_ = false;
    device_ = protocol::ControlDevice::kOnboardComputer;
    authority_lost_ = false;
    emit("did", "obtained");
  }
}

void N1Autopilot::record_loss(bool client_commanded) {
  if (client_commanded && !authority_lost_) {
    authority_lost_ = true;
    lost_at_ = time_;
    ++record_.losses;
  }
}

void N1Autopilot::drop_control(std::string_view why, protocol::ControlDevice now_in_control) {
  const bool was_client = client_in_control();
  record_loss(was_client || virtual_rc_on_);
  device_ = now_in_control;
  moving_ = false;
  end_task_with_control();
  requested_once_ = false;
  if (was_client) {
    emit("did", why);
    if (!config_.behaviour.control.lost_push) {
      return;
    }
    const core::Expected<protocol::Value> value = encode(protocol::ControlLost{});
    push(protocol::ids::kControlLost, *value);
  }
}

void N1Autopilot::switch_rc(bool on) {
  rc_on_ = on;
  emit("did", on ? "rc_on" : "rc_off");
  if (!on) {
    drop_control("rc_off", protocol::ControlDevice::kRemoteController);
  }
}

void N1Autopilot::take_control(bool mobile) {
  mobile_wants_control_ = mobile;
  drop_control(mobile ? "taken_by_mobile" : "taken_by_rc",
               mobile ? protocol::ControlDevice::kMobileApp : protocol::ControlDevice::kRemoteController);
  end_virtual_rc("taken");
}

void N1Autopilot::end_virtual_rc(std::string_view why) {
  if (!virtual_rc_on_) {
    return;
  }
  record_loss(true);
  virtual_rc_on_ = false;
  emit("did", why);
  if (config_.behaviour.virtual_rc.end_gives_control_back) {
    drop_control("virtual_rc_ended", protocol::ControlDevice::kRemoteController);
  }
}

void N1Autopilot::restart() {
  emit("did", "restart");
  record_loss(client_in_control() || virtual_rc_on_);
  activated_ = false;
  device_ = protocol::ControlDevice::kRemoteController;
  requested_once_ = release_requested_once_ = lost_by_mode_ = virtual_rc_on_ = moving_ = task_open_ = task_done_ =
      false;
  sessions_.reset();
  parser_ = {};
  line_.clear();
  off_until_ = time_ + duration_of(config_.behaviour.telemetry.silent_after_restart_s);
  landed_at_ = {};
  task_ = {};
  booted_at_tick_ = ticks_;
  slot_ = 0;
}

void N1Autopilot::command_vehicle() {
  if (moving_ && time_ - last_movement_ > duration_of(config_.behaviour.movement.timeout_s)) {
    moving_ = false;
    emit("did", "movement_timed_out");
    if (config_.behaviour.movement.timeout_gives_control_back) {
      drop_control("movement_timed_out", protocol::ControlDevice::kRemoteController);
    }
  }
  if (task_open_ && !task_done_) {
    vehicle_.command(task_input());
  } else if (virtual_rc_on_) {
    vehicle_.command(virtual_sticks());
  } else if (moving_) {
    vehicle_.command(movement_input());
  } else if (client_in_control()) {
    vehicle_.command(MovementInput{});  // hovers by its own attitude hold, which has the right trim
  } else {
    vehicle_.command(pilot_sticks_);
  }
}

StickInput N1Autopilot::virtual_sticks() const {
  const N1Behaviour::VirtualRc& how = config_.behaviour.virtual_rc;
  constexpr double kFull_counts = 660.0;
  const auto channel = [&](std::size_t index, double sign) {
    const double from_centre = static_cast<double>(virtual_rc_.channels[index]) - protocol::kStickCentre_counts;
    return protocol::kStickCentre_counts + sign * from_centre * kFull_counts / how.full_deflection_counts;
  };
  return {.roll_vrc = channel(protocol::vrc_channel::kRoll, how.roll_sign),
          .pitch_vrc = channel(protocol::vrc_channel::kPitch, how.pitch_sign),
          .throttle_vrc = channel(protocol::vrc_channel::kThrottle, how.throttle_sign),
          .yaw_vrc = channel(protocol::vrc_channel::kYaw, how.yaw_sign)};
}

MovementInput N1Autopilot::movement_input() const {
  const N1Behaviour::Movement& how = config_.behaviour.movement;
  const MovementInput input = movement_.input(vehicle_.state());
  return {.roll_rad = how.roll_sign * input.roll_rad,
          .pitch_rad = how.pitch_sign * input.pitch_rad,
          .climb_m_s = how.climb_sign * input.climb_m_s,
          .yaw_rate_rad_s = how.yaw_sign * input.yaw_rate_rad_s};
}

void N1Autopilot::watch_transmitter() {
  const bool was_his = transmitter_since_ != core::TimePoint::max();
  const bool is_his = transmitter_in_control();
  if (was_his != is_his) {
    transmitter_since_ = is_his ? time_ : core::TimePoint::max();
    emit("did", is_his ? "transmitter_has_control" : "transmitter_lost_control");
  }
  if (is_his && config_.pilot_holds_position) {
    pilot_sticks_ = pilot_.fly(vehicle_.state(), kTick);
  } else if (!is_his) {
    pilot_.stop();
    pilot_sticks_ = pilot_.resting();
  }
}

MovementInput N1Autopilot::task_input() {
  const VehicleState& state = vehicle_.state();
  const N1Behaviour::Tasks& how = config_.behaviour.tasks;
  const bool climbing = task_ == protocol::Task::kTakeOff;
  task_done_ = climbing ? state.position_w_m.z() >= how.take_off_height_m : !state.in_air;
  if (tasks_ == 3.0) {  // endless: begun, but without effect
    task_done_ = false;
    return {};
  }
  if (!task_done_) {
    return {.climb_m_s = climbing ? how.take_off_climb_m_s : -how.landing_sink_m_s};
  }
  emit("did", climbing ? "taken_off" : "landed");
  if (!climbing) {
    vehicle_.set_motors(false);
    landed_at_ = time_;
    task_open_ = false;
  }
  return {};
}

void N1Autopilot::end_task_with_control() {
  if (config_.behaviour.tasks.end_with_control) {
    end_task();
  }
}

void N1Autopilot::end_task() {
  if (task_open_ && !task_done_) {
    emit("did", "task_ended");
  }
  task_open_ = false;
}

}  // namespace m100::sim
