// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/flight_controller.h"

#include "firmware/core/frames.h"
#include "firmware/ctl/law/brake_and_hold.h"

namespace m100::app {
namespace {

/// From the tick that sends a stick to the autopilot's use of it: half a tick; 82 bytes take 3.6 ms at 230400 baud.
constexpr core::Duration kUplink = core::kTickPeriod / 2;
template <typename T>
constexpr T kNotToBeUsed = T(1e6);  ///< variance [m^2/s^2] of a velocity that nothing may be computed from

/// Brings a new pose into the flight's world; if the source's world has moved, the fence is narrowed. Not inlined: its
/// numbers leave the stack before the next poses are read.
template <typename T>
[[gnu::noinline]] void enter_flight(core::Pose<T>& pose, PoseInput<T>& poses, const est::Estimate<T>& estimate,
                                    ctl::GeofenceLimiter<T>& geofence, const core::Fence& fence, core::TimePoint now) {
  if (poses.enter_flight(pose, estimate, now)) {
    geofence.intersect(poses.source_frame().moved(fence));
  }
}

/// The lever arm that was found comes on top of the one that the flight file states; zero: none was found.
std::array<double, 3> whole_lever(std::array<double, 3> found_b_m, const link::LeverArm& stated_b_m) {
  if (found_b_m[0] != 0.0 || found_b_m[1] != 0.0) {
    for (std::size_t axis = 0; axis < found_b_m.size(); ++axis) {
      found_b_m[axis] += static_cast<double>(stated_b_m[axis]);
    }
  }
  return found_b_m;
}

}  // namespace

template <typename T, typename S>
[[gnu::cold]] FlightController<T, S>::FlightController(const model::Vehicle& vehicle, const mpc::GainTables<T>& tables,
                                                       const FlightConfig& config, hal::Uart& autopilot,
                                                       hal::Uart& pose, ref::Trajectory<T>& trajectory,
                                                       log::FlightLogWriter* log)
    : orders_(config.order_timeout),
      recorder_(log),
      link_(autopilot, config.link, recorder_.autopilot_tap()),
      poses_(pose, config.pose_baud, recorder_.pose_tap(), config.pose_from,
             link::PoseProperties::inside(config.fence, config.pose_sigma_m, config.pose_offset_b_m)),
      sensors_(config.sensor_limits),
      observer_(vehicle, config.paper_law ? est::Tilts::kIdentified : est::Tilts::kDesigned),
      fault_isolation_(config.disabled_checks),
      trajectory_(trajectory),
      law_(vehicle, tables, {.horizontal = config.law, .paper_state = config.paper_law}),
      design_(vehicle, config.link.channel.channel == link::Channel::kVirtualRc),
      geofence_(config.fence, ctl::braking_of(vehicle, static_cast<double>(law_.slope_limit()))),
      excitation_(config.excitation),
      monitors_(vehicle, geofence_.braking(), config.attitude_age + kUplink, config.responds_to_limit_cycles),
      supervisor_(config.limits, config.envelope),
      sender_(vehicle, config.link.channel.channel,
              config.paper_law ? vrc::StickRule::kAsThePaper : vrc::StickRule::kCarriesRemainder),
      config_(config) {}

template <typename T, typename S>
core::Status FlightController<T, S>::tick(core::TimePoint now) {
  const Sensed sensed = sense(now);
  observe(sensed);
  const Wanted wanted = command(sensed.acting, now);
  return act(wanted, sensed.measured, now);
}

template <typename T, typename S>
typename FlightController<T, S>::Sensed FlightController<T, S>::sense(core::TimePoint now) {
  timer_.update(now);
  orders_.update(is_in_reach(), supervisor_.failsafe_state(), link_, now);  // -> requests for control
  const protocol::Telemetry& telemetry = link_.receive(now);                // bytes -> frames -> telemetry
  const ctl::Command<T>& sent = sender_.update(link_.authority().in_control, telemetry);
  const ctl::Command<T> acting = config_.paper_law ? sent : design_.expected(sent);
  return {telemetry, acting, adapt(telemetry, now)};  // -> our units and frames, once
}

template <typename T, typename S>
void FlightController<T, S>::observe(const Sensed& sensed) {
  const core::Duration elapsed = timer_.elapsed();
  observer_.update(sensed.measured, sensed.acting, elapsed, heading_reset());  // -> state estimate
  fault_isolation_.update(SensorAdapter::imu_sample<T>(sensed.telemetry, sensed.measured), sensed.measured, estimate_,
                          observer_.model_tilt_rad(), supervisor_.failsafe_state(), elapsed);  // sensors agree?
  monitors_.update_flight_state(link_, estimate_, observer_.model_tilt_rad(), fault_isolation_, elapsed);
}

template <typename T, typename S>
typename FlightController<T, S>::Wanted FlightController<T, S>::command(const ctl::Command<T>& acting,
                                                                        core::TimePoint now) {
  prepare_start(now);  // course and law begin anew until the law flies
  const bool leaves = may_leave(now);
  const bool solves = leaves || !config_.solves_when_due;
  const std::size_t points = solves ? ref::kHorizon + 1 : 1;
  trajectory_.fill(reference_, now, law_.lead(), points);  // -> reference
  plan(now, points);
  hold_fence(now, points);  // inside, and where one can stop
  const ctl::Command<T> told = config_.paper_law ? design_.expected(acting) : acting;
  return {excite(design_.to_send(law_.update(estimate_, reference_, told, timer_.elapsed(), solves)), now), leaves};
}

template <typename T, typename S>
core::Status FlightController<T, S>::act(const Wanted& wanted, const est::Measurement<T>& measured,
                                         core::TimePoint now) {
  const core::Duration elapsed = timer_.elapsed();
  monitors_.update(estimate_, reference_, flies(), excitation_.moves(), elapsed, law_);
  record_.supervised = supervise(wanted, now);                                               // it may only restrict
  record_.sent = sender_.send(record_.supervised, wanted.command, excitation_, link_, now);  // -> sticks -> bytes
  monitors_.update_model(measured, estimate_, sender_.sticks(), sender_.uses_sticks() && link_.authority().in_control,
                         holds(), elapsed);
  apply_learned_trims();
  record_.wanted = wanted.command;
  record_.keep_newest(measured);
  if (recorder_.writes()) {
    recorder_.append(record());
  }
  return record_.sent;
}

template <typename T, typename S>
const TickRecord<T>& FlightController<T, S>::record() {
  ref::Window<T> course;
  trajectory_.fill(course, timer_.last(), core::Duration{0}, 1);
  record_.now = timer_.last();
  record_.elapsed = timer_.elapsed();
  record_.orders = orders_.acting();
  record_.estimate = estimate_;
  record_.course_w_m = {course.x[0].position_m, course.y[0].position_m, course.height.position_m};
  record_.reference = {reference_.x[0], reference_.y[0], reference_.height};
  record_.reference_yaw_rad = reference_.yaw_rad;
  record_.sticks = sender_.sticks();
  record_.seen = supervisor_.observed();
  record_.conditions = supervisor_.conditions();
  record_.law = law_.report();
  record_.excitation = logged(excitation_, record_.now);
  record_.residual = monitors_.residual().report(monitors_.residual().worst()).ratio;
  record_.telemetry = link_.telemetry();
  record_.authority = link_.authority();
  record_.health = link_.health();
  record_.poses = poses_.link().stats();
  record_.source_frame = poses_.source_frame();
  return record_;
}

/// An aircraft that brakes with a false heading accelerates, so no refused heading is adopted until the pilot flies.
template <typename T, typename S>
est::HeadingReset FlightController<T, S>::heading_reset() const {
  return supervisor_.ends() ? est::HeadingReset::kNever
         : flies()          ? est::HeadingReset::kConfirmed
                            : est::HeadingReset::kFree;
}

template <typename T, typename S>
bool FlightController<T, S>::holds() const {
  return supervisor_.failsafe_state() == safety::FailsafeState::kNominal && reference_.constant &&
         !excitation_.moves() && !law_.fallback() && fault_isolation_.trusts_poses();
}

template <typename T, typename S>
void FlightController<T, S>::apply_learned_trims() {
  if (config_.paper_law) {
    return;
  }
  const T share = monitors_.trim().learned_share();
  sender_.set_learned_trims(monitors_.trim().learned());
  observer_.reduce_input_offset(share);
  fault_isolation_.subtract_input_offset({share * estimate_.x.input_offset_rad, share * estimate_.y.input_offset_rad});
}

/// Computes the measurement of this tick. From the previous tick it takes the disturbance acceleration and, for the
/// pose timing, the estimated yaw.
template <typename T, typename S>
est::Measurement<T> FlightController<T, S>::adapt(const protocol::Telemetry& telemetry, core::TimePoint now) {
  const core::Pose<double> pose = poses_.receive(timer_.is_stall(), now);
  est::Measurement<T> measured =
      sensors_.update<T>(telemetry, config_.attitude_age, pose, fault_isolation_.disturbance_acceleration(), now);
  enter_flight(measured.pose, poses_, estimate_, geofence_, config_.fence, now);
  poses_.date(measured, estimate_.heading());
  return measured;
}

/// Whether the aircraft is within reach of the reference, which stays at the beginning of the course until the law
/// flies. True without a healthy estimate: nothing flies then anyway.
template <typename T, typename S>
bool FlightController<T, S>::is_in_reach() const {
  const core::Vector<T, 3> away{estimate_.x.position_m - reference_.x[0].position_m,
                                estimate_.y.position_m - reference_.y[0].position_m,
                                estimate_.height_m - reference_.height.position_m};
  const T reach_m = static_cast<T>(config_.reach_m);
  return !estimate_.healthy || away.squaredNorm() <= reach_m * reach_m;
}

template <typename T, typename S>
ctl::Command<T> FlightController<T, S>::excite(ctl::Command<T> commanded, core::TimePoint now) {
  const bool may = supervisor_.failsafe_state() == safety::FailsafeState::kNominal && link_.authority().in_control;
  if (excitation_.returns()) {
    const est::TrimCounts<T> holding = monitors_.trim().holding(estimate_);
    excitation_.rest_at({.roll_counts = holding.roll, .pitch_counts = holding.pitch});
  }
  excitation_.update(estimate_, reference_, may, geofence_.brakes(), now);
  if (excitation_.moves()) {
    ctl::value_of(commanded, static_cast<std::size_t>(excitation_.axis())) = sender_.excited_command(excitation_);
  }
  return commanded;
}

/// Whether a limit cycle persists, or has ended the flight. Braking by feedback might sustain it, so only trim and wind
/// are compensated then, and the hand-over does not wait for a lower speed.
template <typename T, typename S>
bool FlightController<T, S>::levels_limit_cycle() const {
  return monitors_.limit_cycle_persists() ||
         (supervisor_.ends() && supervisor_.descent().reason == safety::FailsafeReason::kLimitCycle);
}

/// Uses FaultIsolation's motion: braking by an estimate from false poses would follow them.
template <typename T, typename S>
ctl::Command<T> FlightController<T, S>::brake_and_hold() const {
  if (orders_.takes_off()) {  // on the ground there is nothing to brake
    return {};
  }
  est::Estimate<T> motion = fault_isolation_.motion(estimate_);
  if (levels_limit_cycle()) {
    motion.x.velocity_variance_m2_s2 = motion.y.velocity_variance_m2_s2 = kNotToBeUsed<T>;
  }
  return ctl::brake_and_hold(motion, geofence_.braking());
}

template <typename T, typename S>
void FlightController<T, S>::plan(core::TimePoint now, std::size_t points) {
  if (config_.paper_law) {
    ctl::remove_accelerations(reference_);
  } else if (config_.plans_setpoints && flies() && !excitation_.moves()) {
    law_.plan(reference_, estimate_, geofence_, now, points);
  }
}

template <typename T, typename S>
[[gnu::noinline]] void FlightController<T, S>::hold_fence(core::TimePoint now, std::size_t points) {
  const std::optional<est::Estimate<T>> other_motion = fault_isolation_.fence_motion(estimate_);
  geofence_.limit(reference_, other_motion ? *other_motion : estimate_, now, law_.lead(), points,
                  other_motion ? &estimate_ : nullptr);
}

template <typename T, typename S>
void FlightController<T, S>::prepare_start(core::TimePoint now) {
  if (!flies()) {
    trajectory_.start(now);
    law_.reset();
    geofence_.reset();
  } else if (supervisor_.failsafe_state() == safety::FailsafeState::kCoast || timer_.is_stall()) {
    trajectory_.postpone(now, timer_.elapsed());
  }
}

/// Lets the supervisor choose and limit the command. The slew limit counts between commands that can leave.
template <typename T, typename S>
safety::SupervisedCommand<T> FlightController<T, S>::supervise(const Wanted& wanted, core::TimePoint now) {
  const safety::FailsafeState before = supervisor_.failsafe_state();
  safety::Observation& seen = supervisor_.observation();
  seen.now = now;
  seen.estimate = est::status_of(estimate_);
  seen.pose_latency = poses_.latency();
  seen.consistency = fault_isolation_.status(estimate_, before, levels_limit_cycle(), config_.limits);
  seen.consistency.lever_b_m = whole_lever(seen.consistency.lever_b_m, config_.pose_offset_b_m);
  seen.link = link_.status();
  seen.orders = orders_.status(is_in_reach(), now);
  seen.fence = geofence_.status();
  seen.wind = monitors_.wind();
  seen.limit_cycle = monitors_.limit_cycle();
  seen.flight = monitors_.flight_state();
  seen.model = monitors_.model();
  const safety::CommandSource source = supervisor_.update_failsafe(wanted.command, seen);
  const bool brakes = source == safety::CommandSource::kBrakeAndHold;
  safety::SupervisedCommand<T> supervised;
  if (wanted.may_leave || source != safety::CommandSource::kLaw) {
    supervised = supervisor_.limit_command(source, brakes ? brake_and_hold() : wanted.command, timer_.elapsed());
  } else if (config_.solves_when_due) {
    supervised = supervisor_.hold_command(source, timer_.elapsed());
  } else {
    supervised = supervisor_.preview_command(source, wanted.command, timer_.elapsed());
  }
  start_when_nominal(before, now);
  orders_.release_unused(supervised.failsafe_state, link_, now);
  return supervised;
}

template <typename T, typename S>
bool FlightController<T, S>::may_leave(core::TimePoint now) const {
  const bool flies_sticks = flies() && link_.authority().in_control;
  return !flies_sticks || law_.fallback() || link_.due(now);
}

template <typename T, typename S>
void FlightController<T, S>::start_when_nominal(safety::FailsafeState before, core::TimePoint now) {
  const bool flew = before == safety::FailsafeState::kNominal || before == safety::FailsafeState::kCoast;
  if (supervisor_.failsafe_state() != safety::FailsafeState::kNominal || flew) {
    return;
  }
  orders_.serve(now);
  excitation_.start(now);
  sender_.reset();
}

template class FlightController<double>;
template class FlightController<float>;
template class FlightController<float, core::Fixed>;

}  // namespace m100::app
