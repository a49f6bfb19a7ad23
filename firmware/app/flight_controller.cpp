// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/flight_controller.h"

#include "firmware/core/assert.h"
#include "firmware/core/frames.h"
#include "firmware/core/maths.h"
#include "firmware/ctl/settle.h"

namespace m100::app {
namespace {

constexpr core::Duration kStall = 2 * core::kTickPeriod;  // promise R9
/// From the tick that sends a stick to the autopilot's using it: half a tick, in which a frame passes at 115200 baud.
constexpr core::Duration kUplink = core::kTickPeriod / 2;
constexpr double kErrorSigmas = 3.0;
template <typename T>
constexpr T kNotToBeUsed = T(1e6);  ///< variance [m^2/s^2] of a velocity that nothing may be computed from
constexpr int kBacklogReads = 32;   ///< of PoseLink::kBytesPerTick: more than a driver holds
/// Control that is ours but not used, because no pose arrives, goes back after this time: it blocks the pilot's sticks.
/// Shorter than the second after which the autopilot ends Virtual RC by itself.
constexpr core::Duration kUnusedControl = std::chrono::milliseconds(800);

}  // namespace

template <typename T, typename S>
[[gnu::cold]] FlightController<T, S>::FlightController(const model::Vehicle& vehicle, const mpc::GainTables<T>& tables,
                                                       const FlightConfig& config, hal::Uart& autopilot,
                                                       hal::Uart& pose, ref::Trajectory<T>& trajectory,
                                                       log::FlightLogWriter* log)
    : autopilot_tap_(log, log::Stream::kAutopilotIn, log::Stream::kAutopilotOut),
      pose_tap_(log, log::Stream::kPoseIn, log::Stream::kPoseOut),
      link_(autopilot, config.link, &autopilot_tap_),
      pose_link_(pose, config.pose_baud, &pose_tap_),
      measure_(config.plausible),
      observer_(model::controller_model(vehicle)),
      trust_(config.checks_off),
      trajectory_(trajectory),
      law_(vehicle, tables, {.horizontal = config.law}),
      design_(vehicle, config.link.channel.channel == link::Channel::kVirtualRc),
      braking_(ctl::braking_of(vehicle, static_cast<double>(law_.slope_limit()))),
      fence_(config.fence, braking_),
      place_(braking_),
      swing_(braking_, config.answers_swings),
      excitation_(config.excitation),
      supervisor_(config.limits, config.envelope),
      commands_(vehicle),
      residual_(vehicle, typename sysid::ResidualMonitor<T>::Expected{}, core::seconds<T>(core::kTickPeriod),
                core::seconds<T>(config.attitude_age + kUplink)),
      trim_(vehicle),
      log_(log),
      config_(config) {}

template <typename T, typename S>
core::Status FlightController<T, S>::tick(core::TimePoint now) {
  note_time(now);
  take_orders(now);
  const protocol::Telemetry& telemetry = link_.receive(now);  // bytes -> frames -> telemetry
  if (!link_.authority().in_control) {
    in_force_ = pilots_command(telemetry);
  }
  est::Measurement<T> measured = measure_.update<T>(telemetry, config_.attitude_age, pose(now), now);
  measured.push = trust_.push();                                // what was felt beside the tilt
  timing_.update(measured, estimate_.yaw_rad);                  // times of capture as they were, not as told
  const ctl::Command<T> acting = design_.expected(in_force_);
  estimate_ = observer_.update(measured, acting, elapsed_);  // -> state estimate
  trust_.update(Measure::felt<T>(telemetry, measured), measured, estimate_, observer_.asked_tilt_rad(),
                supervisor_.rung(), elapsed_);  // against autopilot
  stand_ready(now);                             // a flight that begins in this tick begins here
  const bool solves = may_leave(now);
  const std::size_t points = solves ? ref::kHorizon + 1 : 1;
  trajectory_.fill(reference_, now, law_.lead(), points);  // -> reference
  fence_.hold(reference_, estimate_, points);              // inside the fence, and where one can stop
  wanted_ = design_.to_send(law_.update(estimate_, reference_, acting, elapsed_, solves));  // -> control
  excite(now);  // one stick by the plan, where there is one
  const safety::Rung before = supervisor_.rung();
  place_.update(estimate_, reference_, safety::passes_law(before), core::seconds<T>(elapsed_));
  swing_.update(estimate_, reference_, safety::passes_law(before), excitation_.moves(), core::seconds<T>(elapsed_),
                law_);
  observed_ = observation(now);
  grant_ = granted(solves);  // takes away
  start_when_nominal(before, now);
  give_back_unused(now);
  const core::Status sent = send(grant_, now);  // -> Virtual RC -> bytes
  remember(measured);
  watch_residual();
  if (log_ != nullptr) {
    if (excitation_.state() != ctl::Excitation<T>::State::kIdle) {
      log_->append(excitation_record(now));
    }
    log_->append(record(now, sent));
  }
  return sent;
}

template <typename T, typename S>
void FlightController<T, S>::take_orders(core::TimePoint now) {
  tick_orders_ = orders_;
  orders_ = 0;
  if ((tick_orders_ & log::kOrderEngage) != 0 && !safety::passes_law(supervisor_.rung()) && is_in_reach()) {
    link_.request_control(now);
    order_until_ = now + config_.order_lasts;
  }
  if (order_stands_ && now >= order_until_ && supervisor_.rung() == safety::Rung::kSilent) {
    link_.release(now);  // the order has expired: an ask that still waits must not be served later
  }
  if ((tick_orders_ & log::kOrderRelease) != 0) {
    order_until_ = now;
    if (supervisor_.rung() == safety::Rung::kSilent) {
      link_.release(now);  // nothing flies yet: requested or granted control goes back at once
    }
  }
  order_stands_ = now < order_until_;
}

/// Near the place where the course begins. Without a known position nothing flies, so the order is not refused for it.
template <typename T, typename S>
bool FlightController<T, S>::is_in_reach() const {
  const core::Vector<T, 3> away{estimate_.x.position_m - reference_.x[0].position_m,
                                estimate_.y.position_m - reference_.y[0].position_m,
                                estimate_.height_m - reference_.height.position_m};
  const T reach_m = static_cast<T>(config_.reach_m);
  return !estimate_.healthy || away.squaredNorm() <= reach_m * reach_m;
}

template <typename T, typename S>
void FlightController<T, S>::give_back_unused(core::TimePoint now) {
  const bool unused = link_.authority().in_control && grant_.rung == safety::Rung::kSilent;
  unused_since_ = unused ? unused_since_ : now;
  if (unused && now - unused_since_ > kUnusedControl) {
    link_.release(now);
  }
}

template <typename T, typename S>
void FlightController<T, S>::note_time(core::TimePoint now) {
  M100_ASSERT(stats_.ticks == 0 || now >= last_tick_);
  elapsed_ = stats_.ticks == 0 ? core::kTickPeriod : now - last_tick_;
  stats_.stalls += elapsed_ > kStall ? 1U : 0U;
  stats_.longest = elapsed_ > stats_.longest ? elapsed_ : stats_.longest;
  stats_.ticks += 1;
  last_tick_ = now;
}

template <typename T, typename S>
void FlightController<T, S>::remember(const est::Measurement<T>& measured) {
  if (measured.pose.is_new) {
    measured_.pose = measured.pose;
  }
  if (measured.attitude.is_new) {
    measured_.attitude = measured.attitude;
  }
  measured_.pose.is_new = measured.pose.is_new;
  measured_.attitude.is_new = measured.attitude.is_new;
}

template <typename T, typename S>
void FlightController<T, S>::watch_residual() {
  const bool flies_sticks = config_.link.channel.channel == link::Channel::kVirtualRc && link_.authority().in_control;
  trim_.update(estimate_, flies_sticks && reference_.constant && !excitation_.moves(), core::seconds<T>(elapsed_));
  if (!flies_sticks || !measured_.attitude.is_new || elapsed_ > kStall) {
    residual_.interrupt();
    return;
  }
  const auto counts = [](vrc::Stick stick) { return static_cast<T>(static_cast<int>(stick) - 1024); };
  // In the order of sysid::MonitoredAxis; the yaw stick is positive to the right. The gyro's z rate is the heading's
  // rate only while the aircraft is level: at 20 degrees of roll it includes a third of the pitch rate.
  const typename est::Measurement<T>::Attitude& attitude = measured_.attitude;
  const core::Turn<T>& roll = attitude.roll();
  const T heading_rate_rad_s =
      (roll.sine * attitude.rate_b_rad_s.y() + roll.cosine * attitude.rate_b_rad_s.z()) / attitude.pitch().cosine;
  const est::TrimCounts<T>& trim = trim_.now();
  residual_.update({.stick_counts = {counts(last_sticks_.roll) - trim.roll, counts(last_sticks_.pitch) - trim.pitch,
                                     counts(last_sticks_.yaw), counts(last_sticks_.throttle)},
                    .measured = {attitude.roll_rad, attitude.pitch_rad, -heading_rate_rad_s, estimate_.climb_m_s}});
}

template <typename T, typename S>
core::Pose<double> FlightController<T, S>::pose(core::TimePoint now) {
  const core::Expected<core::Pose<double>> came = pose_link_.receive(now);
  pose_link_.ask_time(now);
  if (elapsed_ > kStall) {
    // Poses that waited during the stall are older than they state, by an unknown time: the next tick has a fresh one.
    for (int backlog = 0; backlog < kBacklogReads && pose_link_.receive(now); ++backlog) {
    }
    return {};
  }
  return came ? *came : core::Pose<double>{};
}

/// Braking by feedback might keep the aircraft swinging. Then only trim and wind are compensated, and the hand-over
/// does not wait for the speed, which nothing reduces.
template <typename T, typename S>
bool FlightController<T, S>::levels_a_swing() const {
  const bool settles = supervisor_.rung() == safety::Rung::kLevel || supervisor_.rung() == safety::Rung::kRelease;
  return swing_.goes_on() || (settles && supervisor_.descent().cause == safety::Cause::kSwinging);
}

/// Braking by a contradicted estimate would follow the false poses.
template <typename T, typename S>
ctl::Command<T> FlightController<T, S>::settled() const {
  if ((tick_orders_ & log::kOrderTakesOff) != 0) {  // on the ground there is nothing to brake
    return {};
  }
  est::Estimate<T> motion = trust_.motion(estimate_);
  if (levels_a_swing()) {
    motion.x.velocity_variance_m2_s2 = motion.y.velocity_variance_m2_s2 = kNotToBeUsed<T>;
  }
  return ctl::settle(motion, braking_);
}

template <typename T, typename S>
safety::Observation FlightController<T, S>::observation(core::TimePoint now) {
  safety::Observation observed{
      .now = now,
      .pose_age = estimate_.pose_age,
      .telemetry_age = link_.health().telemetry_age,
      .pose_latency = {.least = timing_.report().least,
                       .jitter = timing_.report().jitter,
                       .interval = timing_.report().interval},
      .error_m =
          static_cast<double>(T(kErrorSigmas) * core::sqrt(core::clamp(estimate_.x.position_variance_m2,
                                                                       estimate_.y.position_variance_m2, T(1e6)))),
      .reserve_m = static_cast<double>(fence_.reserve_m()),
      .outside_m = static_cast<double>(fence_.outside_m()),
      .place_lost_for = core::Duration(static_cast<core::Duration::rep>(place_.lost_s() * T(1e6))),
      .push_m_s2 = static_cast<double>(place_.push_m_s2()),
      .swing_rad = static_cast<double>(swing_.seen().height_rad),
      .swing_hz = static_cast<double>(swing_.seen().frequency_hz),
      .swings = law_.calm(),
      .swings_on = swing_.goes_on(),
      .estimate_healthy = estimate_.healthy,
      .authority = link_.authority().in_control,
      .mode_f = link_.authority().mode_f,
      .operator_engages = now < order_until_ && is_in_reach(),
      .operator_releases = (tick_orders_ & log::kOrderRelease) != 0,
      .task_flies = (tick_orders_ & (log::kOrderTakesOff | log::kOrderLands)) != 0,
      .left_model = {residual_.report(sysid::MonitoredAxis::kRoll).departed,
                     residual_.report(sysid::MonitoredAxis::kPitch).departed,
                     residual_.report(sysid::MonitoredAxis::kYawRate).departed,
                     residual_.report(sysid::MonitoredAxis::kClimb).departed},
      .trim_drifted = trim_.report().drifted};
  trust_.tell(observed, estimate_, config_.limits.gate_shut);
  if (levels_a_swing()) {
    observed.speed_m_s = 0.0;
  } else if (supervisor_.rung() == safety::Rung::kLevel) {
    observed.speed_then_m_s = trust_.speed_then_m_s(estimate_, config_.limits.neutral);
  }
  return observed;
}

template <typename T, typename S>
void FlightController<T, S>::stand_ready(core::TimePoint now) {
  if (safety::passes_law(supervisor_.rung())) {
    return;
  }
  trajectory_.start(now);
  law_.reset();
}

/// The granted command is held until the next one can leave: the slew limit is between commands that leave.
template <typename T, typename S>
safety::Grant<T> FlightController<T, S>::granted(bool solved) {
  const safety::Passes passes = supervisor_.step_ladder(wanted_, observed_);
  slew_time_ += elapsed_;
  if (passes == safety::Passes::kWanted && !solved) {
    return supervisor_.limit_command(passes, grant_.command, T(0));
  }
  const T step_s = core::seconds<T>(slew_time_);
  slew_time_ = core::Duration{0};
  return supervisor_.limit_command(passes, passes == safety::Passes::kSettled ? settled() : wanted_, step_s);
}

template <typename T, typename S>
bool FlightController<T, S>::may_leave(core::TimePoint now) const {
  const bool flies = safety::passes_law(supervisor_.rung()) && link_.authority().in_control;
  return !config_.solves_when_due || !flies || law_.calm() || link_.due(now);
}

template <typename T, typename S>
void FlightController<T, S>::start_when_nominal(safety::Rung before, core::TimePoint now) {
  const bool flew = before == safety::Rung::kNominal || before == safety::Rung::kCoast;
  if (grant_.rung != safety::Rung::kNominal || flew) {
    return;
  }
  order_until_ = now;
  started_ = now;
  excitation_.start(now);
  commands_.reset();
}

template class FlightController<double>;
template class FlightController<float>;
template class FlightController<float, core::Fixed>;

}  // namespace m100::app
