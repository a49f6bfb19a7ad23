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
constexpr int kBacklogReads = 32;  ///< of PoseLink::kBytesPerTick: more than a driver holds
/// Control that nobody uses, because no pose comes, keeps the pilot's sticks from the aircraft. Shorter than the second
/// after which the autopilot ends Virtual RC by itself.
constexpr core::Duration kUnusedControl = std::chrono::milliseconds(800);

template <typename To, typename From>
ctl::Command<To> cast(const ctl::Command<From>& command) {
  return {.roll_rad = static_cast<To>(command.roll_rad),
          .pitch_rad = static_cast<To>(command.pitch_rad),
          .climb_m_s = static_cast<To>(command.climb_m_s),
          .yaw_rate_rad_s = static_cast<To>(command.yaw_rate_rad_s)};
}

/// A stick of the RC item, -10000..10000, in counts.
vrc::Stick stick_of(std::int16_t rc) {
  const int counts = 1024 + (rc * 660 + (rc < 0 ? -5000 : 5000)) / 10000;
  return static_cast<vrc::Stick>(core::clamp(counts, 364, 1684));
}

}  // namespace

template <typename T, typename S>
FlightController<T, S>::FlightController(const model::Vehicle& vehicle, const mpc::GainTables<T>& tables,
                                         const FlightConfig& config, hal::Uart& autopilot, hal::Uart& pose,
                                         ref::Trajectory<T>& trajectory, log::FlightLog* log)
    : autopilot_tap_(log, log::Stream::kAutopilotIn, log::Stream::kAutopilotOut),
      pose_tap_(log, log::Stream::kPoseIn, log::Stream::kPoseOut),
      link_(autopilot, config.link, &autopilot_tap_),
      pose_link_(pose, config.pose_baud, &pose_tap_),
      measure_(config.plausible),
      observer_(vehicle),
      cross_check_(config.checks_off),
      trajectory_(trajectory),
      law_(vehicle, tables, {.horizontal = config.law}),
      braking_(ctl::braking_of(vehicle, static_cast<double>(law_.slope_limit()))),
      fence_(config.fence, braking_),
      place_(braking_),
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
  timing_.update(measured, estimate_.yaw_rad);                        // times of capture as they were, not as told
  estimate_ = observer_.update(measured, in_force_, elapsed_);        // -> state estimate
  cross_check(Measure::felt<T>(telemetry, measured));                 // pose against autopilot
  stand_ready(now);                                                   // a flight that begins in this tick begins here
  trajectory_.fill(reference_, now, law_.lead());                     // -> reference
  fence_.hold(reference_, estimate_);                                 // inside the fence, and where one can stop
  wanted_ = law_.update(estimate_, reference_, in_force_, elapsed_);  // -> control
  excite(now);                                                        // one stick by the plan, where there is one
  const safety::Rung before = supervisor_.rung();
  place_.update(estimate_, reference_, safety::passes_law(before), core::seconds<T>(elapsed_));
  observed_ = observation(now);
  grant_ = supervisor_.review(wanted_, settled(), observed_, core::seconds<T>(elapsed_));  // takes away
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
    link_.release(now);  // nothing came of it in its time: an ask that still waits for the autopilot would be another's
  }
  if ((tick_orders_ & log::kOrderRelease) != 0) {
    order_until_ = now;
    if (supervisor_.rung() == safety::Rung::kSilent) {
      link_.release(now);  // nothing flies yet: whatever was asked for, or granted meanwhile, goes back at once
    }
  }
  order_stands_ = now < order_until_;
}

/// Of the place where the course begins; before a place is known nothing flies, and nothing is refused for it.
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
  // In the order of sysid::Channel; the yaw stick is positive to the right. A gyro's z is the heading's rate only while
  // the aircraft is level: at 20 degrees of roll a third of the pitch's rate is in it.
  const typename est::Measurement<T>::Attitude& attitude = measured_.attitude;
  const T heading_rate_rad_s = (core::sin(attitude.roll_rad) * attitude.rate_b_rad_s.y() +
                                core::cos(attitude.roll_rad) * attitude.rate_b_rad_s.z()) /
                               core::cos(attitude.pitch_rad);
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
    // What waited for us is older than its sender knew, and nobody can say by how much: the next tick has a fresh one.
    for (int backlog = 0; backlog < kBacklogReads && pose_link_.receive(now); ++backlog) {
    }
    return {};
  }
  return came ? *came : core::Pose<double>{};
}

template <typename T, typename S>
ctl::Command<T> FlightController<T, S>::pilots_command(const protocol::Telemetry& telemetry) const {
  return cast<T>(commands_.to_command({.roll = stick_of(telemetry.rc.roll),
                                       .pitch = stick_of(telemetry.rc.pitch),
                                       .throttle = stick_of(telemetry.rc.throttle),
                                       .yaw = stick_of(telemetry.rc.yaw)}));
}

/// Poses that are contradicted have taught the observer a false motion; poses that the gate refuses may have, where it
/// is far from the one that is reckoned without them. What was learned stays false until the ladder has ended.
template <typename T, typename S>
void FlightController<T, S>::cross_check(const est::Felt<T>& felt) {
  constexpr T kFar_m_s = T(0.5);
  cross_check_.update(felt, estimate_, reckoning_.push_w_m_s2(), elapsed_);
  const safety::Rung rung = supervisor_.rung();
  const bool contradicted = contradiction().check != est::Check::kNone;
  const core::Vector<T, 2> apart =
      core::Vector<T, 2>(estimate_.x.velocity_m_s, estimate_.y.velocity_m_s) - reckoning_.velocity_w_m_s();
  const bool settles = rung == safety::Rung::kLevel || rung == safety::Rung::kRelease;
  const bool refused = settles && estimate_.refused_poses > 0 && apart.squaredNorm() > kFar_m_s * kFar_m_s;
  lied_to_ = contradicted || refused || (lied_to_ && settles);
  const bool trusted = !lied_to_ && !cross_check_.doubts() && estimate_.refused_poses == 0;
  reckoning_.update(felt, estimate_, cross_check_.felt_h_m_s2(), trusted, elapsed_);
}

/// What brakes by an estimate that is contradicted would fly the lie.
template <typename T, typename S>
ctl::Command<T> FlightController<T, S>::settled() const {
  if ((tick_orders_ & log::kOrderTakesOff) != 0) {  // on the ground nothing is to be braked
    return {};
  }
  return ctl::settle(lied_to_ ? reckoning_.instead_of(estimate_) : estimate_, braking_);
}

/// Of a prediction that is worth nothing, none: nobody waits for it to slow down.
template <typename T, typename S>
double FlightController<T, S>::speed_m_s() const {
  constexpr T kWorthless_m2_s2 = T(1);
  const est::Estimate<T> motion = lied_to_ ? reckoning_.instead_of(estimate_) : estimate_;
  const est::AxisEstimate<T>& x = motion.x;
  const est::AxisEstimate<T>& y = motion.y;
  const bool known = estimate_.predicts && x.velocity_variance_m2_s2 < kWorthless_m2_s2 &&
                     y.velocity_variance_m2_s2 < kWorthless_m2_s2;
  return known ? static_cast<double>(core::sqrt(x.velocity_m_s * x.velocity_m_s + y.velocity_m_s * y.velocity_m_s))
               : 0.0;
}

template <typename T, typename S>
safety::Observation FlightController<T, S>::observation(core::TimePoint now) {
  const est::Contradiction<T>& contradicted = contradiction();
  const core::Duration shut = config_.limits.gate_shut;
  return {.now = now,
          .pose_age = estimate_.pose_age,
          .telemetry_age = link_.health().telemetry_age,
          .pose_latency = {.least = timing_.report().least,
                           .jitter = timing_.report().jitter,
                           .interval = timing_.report().interval},
          .refused_poses = estimate_.refused_poses,
          .refused_for = lied_to_ && estimate_.refused_for < shut ? shut : estimate_.refused_for,
          .refused_by_m = static_cast<double>(estimate_.refusal.distance_m),
          .refused_allowed_m = static_cast<double>(estimate_.refusal.allowed_m),
          .error_m = kErrorSigmas * core::sqrt(static_cast<double>(core::clamp(
                                        estimate_.x.position_variance_m2, estimate_.y.position_variance_m2, T(1e6)))),
          .reserve_m = static_cast<double>(fence_.reserve_m()),
          .outside_m = static_cast<double>(fence_.outside_m()),
          .speed_m_s = speed_m_s(),
          .place_lost_for = core::Duration(static_cast<core::Duration::rep>(place_.lost_s() * T(1e6))),
          .push_m_s2 = static_cast<double>(place_.push_m_s2()),
          .refused_turn_rad = static_cast<double>(estimate_.refusal.turned_rad),
          .contradicted_by = static_cast<std::uint8_t>(contradicted.check),
          .contradicted_with = static_cast<double>(contradicted.measured),
          .contradicted_allowed = static_cast<double>(contradicted.allowed),
          .estimate_healthy = estimate_.healthy,
          .authority = link_.authority().in_control,
          .mode_f = link_.authority().mode_f,
          .operator_engages = now < order_until_ && is_in_reach(),
          .operator_releases = (tick_orders_ & log::kOrderRelease) != 0,
          .task_flies = (tick_orders_ & (log::kOrderTakesOff | log::kOrderLands)) != 0,
          .left_model = {residual_.report(sysid::Channel::kRoll).departed,
                         residual_.report(sysid::Channel::kPitch).departed,
                         residual_.report(sysid::Channel::kYawRate).departed,
                         residual_.report(sysid::Channel::kClimb).departed},
          .trim_drifted = trim_.report().drifted};
}

template <typename T, typename S>
void FlightController<T, S>::stand_ready(core::TimePoint now) {
  if (safety::passes_law(supervisor_.rung())) {
    return;
  }
  trajectory_.start(now);
  law_.reset();
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

template <typename T, typename S>
vrc::Stick FlightController<T, S>::excited_stick() const {
  const vrc::StickMap& map = commands_.map(static_cast<std::size_t>(excitation_.axis()));
  const int counts = static_cast<int>(map.neutral_vrc + 0.5F) + excitation_.counts();
  return static_cast<vrc::Stick>(core::clamp(counts, 364, 1684));
}

template <typename T, typename S>
void FlightController<T, S>::excite(core::TimePoint now) {
  const bool may = supervisor_.rung() == safety::Rung::kNominal && link_.authority().in_control;
  excitation_.update(estimate_, reference_, may, fence_.brakes(), now);
  if (excitation_.moves()) {
    const auto axis = static_cast<std::size_t>(excitation_.axis());
    ctl::value_of(wanted_, axis) = static_cast<T>(commands_.map(axis).to_command(excited_stick()));
  }
}

/// The map jumps over the dead zone and spreads what it rounds; an excitation has the counts that were asked for, where
/// the supervisor took nothing from them.
template <typename T, typename S>
vrc::Sticks FlightController<T, S>::excited(vrc::Sticks mapped) const {
  const auto axis = static_cast<std::size_t>(excitation_.axis());
  if (excitation_.moves() && ctl::value_of(grant_.command, axis) == ctl::value_of(wanted_, axis)) {
    const std::array<vrc::Stick*, ctl::kStickAxes> all{&mapped.roll, &mapped.pitch, &mapped.throttle, &mapped.yaw};
    *all[axis] = excited_stick();
  }
  return mapped;
}

template <typename T, typename S>
core::Status FlightController<T, S>::send(const safety::Grant<T>& grant, core::TimePoint now) {
  if (grant.release) {
    link_.release(now);
  }
  if (!grant.transmit) {
    return core::Status::kRefused;
  }
  return link_.due(now) ? tell(grant.command, now) : core::Status::kNotReady;
}

template <typename T, typename S>
core::Status FlightController<T, S>::tell(const ctl::Command<T>& command, core::TimePoint now) {
  if (config_.link.channel.channel == link::Channel::kMovement) {
    const core::Status sent = link_.send(cast<double>(command), now);
    in_force_ = sent == core::Status::kOk ? command : in_force_;
    return sent;
  }
  const core::Expected<vrc::Sticks> mapped = commands_.to_sticks(cast<float>(command));
  if (!mapped) {
    return mapped.status();
  }
  const vrc::Sticks sticks = excited(*mapped);
  const core::Status sent = link_.send(sticks, now);
  if (sent == core::Status::kOk) {
    last_sticks_ = sticks;
    in_force_ = cast<T>(commands_.to_command(sticks));
  }
  return sent;
}

template class FlightController<double>;
template class FlightController<float>;
template class FlightController<float, core::Fixed>;

}  // namespace m100::app
