// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/flight_recorder.h"

namespace m100::app {
namespace {

template <typename T>
std::array<double, 4> numbers(const ctl::Command<T>& command) {
  return {static_cast<double>(command.roll_rad), static_cast<double>(command.pitch_rad),
          static_cast<double>(command.climb_m_s), static_cast<double>(command.yaw_rate_rad_s)};
}

template <typename... Values>
std::array<double, sizeof...(Values)> numbers_of(Values... values) {
  return {static_cast<double>(values)...};
}

std::uint16_t counts(vrc::Stick stick) { return static_cast<std::uint16_t>(stick); }

std::uint64_t microseconds(core::TimePoint time) { return static_cast<std::uint64_t>(time.time_since_epoch().count()); }

template <typename T>
log::ExcitationRecord record_of(const ctl::Excitation<T>& excitation, core::TimePoint now) {
  return {.timestamp = microseconds(now),
          .distance = static_cast<float>(excitation.distance()),
          .speed = static_cast<float>(excitation.speed()),
          .counts = static_cast<std::int16_t>(excitation.counts()),
          .sample = static_cast<std::uint16_t>(excitation.sample()),
          .piece = static_cast<std::uint8_t>(excitation.piece()),
          .axis = static_cast<std::uint8_t>(excitation.axis()),
          .state = static_cast<std::uint8_t>(excitation.state()),
          .abort = static_cast<std::uint8_t>(excitation.abort())};
}

}  // namespace

template <typename T>
void FlightRecorder<T>::update_newest(const est::Measurement<T>& measured) {
  if (measured.pose.is_new) {
    newest_.pose = measured.pose;
  }
  if (measured.attitude.is_new) {
    newest_.attitude = measured.attitude;
  }
  newest_.pose.is_new = measured.pose.is_new;
  newest_.attitude.is_new = measured.attitude.is_new;
}

template <typename T>
void FlightRecorder<T>::append(const FlownTick<T>& flown, const link::SerialLink& link,
                               const safety::Supervisor<T>& supervisor, const ctl::FlightLaw<T>& law,
                               const sysid::ResidualMonitor<T>& residual, const ctl::Excitation<T>& excitation) {
  if (log_ == nullptr) {
    return;
  }
  if (excitation.state() != ctl::Excitation<T>::State::kIdle) {
    log_->append(record_of(excitation, flown.now));
  }
  update_newest(flown.measured);
  log::TickRecord out = record(flown);
  out.telemetry_age = core::seconds<float>(link.health().telemetry_age);
  out.link_state = static_cast<std::uint8_t>(link.authority().stage);
  out.facts = static_cast<std::uint32_t>(supervisor.conditions());
  out.residual = static_cast<float>(residual.report(residual.worst()).ratio);
  out.dropped_messages = log_->dropped();
  out.mpc_path_x = static_cast<std::uint8_t>(law.report().path_x);
  out.mpc_path_y = static_cast<std::uint8_t>(law.report().path_y);
  out.mpc_changes = static_cast<std::uint8_t>(law.report().changes < 255U ? law.report().changes : 255U);
  log_->append(out);
}

template <typename T>
log::TickRecord FlightRecorder<T>::record(const FlownTick<T>& flown) const {
  const est::Estimate<T>& e = flown.estimate;
  const ref::Window<T>& r = flown.reference;
  log::TickRecord out;
  out.timestamp = microseconds(flown.now);
  out.position = numbers_of(e.x.position_m, e.y.position_m, e.height_m);
  out.velocity = numbers_of(e.x.velocity_m_s, e.y.velocity_m_s, e.climb_m_s);
  out.attitude = numbers_of(e.y.tilt_rad, e.x.tilt_rad, e.yaw_rad);
  out.tilt_rate = numbers_of(e.y.tilt_rate_rad_s, e.x.tilt_rate_rad_s);
  out.disturbance = numbers_of(e.x.disturbance_m_s2, e.y.disturbance_m_s2);
  out.input_offset = numbers_of(e.x.input_offset_rad, e.y.input_offset_rad);
  out.climb_offset = static_cast<double>(e.climb_offset_m_s);
  out.ref_position = numbers_of(r.x[0].position_m, r.y[0].position_m, r.height.position_m);
  out.ref_velocity = numbers_of(r.x[0].velocity_m_s, r.y[0].velocity_m_s, r.height.velocity_m_s);
  out.ref_acceleration = numbers_of(r.x[0].acceleration_m_s2, r.y[0].acceleration_m_s2);
  out.ref_yaw = static_cast<double>(r.yaw_rad);
  const auto& p = newest_.pose.position_w_m;
  out.pose_position = numbers_of(p.x(), p.y(), p.z());
  out.pose_yaw = static_cast<double>(newest_.pose.yaw_rad);
  const auto& a = newest_.attitude;
  out.imu_attitude = numbers_of(a.roll_rad, a.pitch_rad, a.yaw_rad);
  out.imu_rate = numbers_of(a.rate_b_rad_s.x(), a.rate_b_rad_s.y(), a.rate_b_rad_s.z());
  out.wanted = numbers(flown.commanded);
  out.granted = numbers(flown.supervised.command);
  out.pose_age = core::seconds<float>(e.pose_age);
  out.late = core::seconds<float>(flown.elapsed - core::kTickPeriod);
  out.sticks = {counts(flown.sticks.roll), counts(flown.sticks.pitch), counts(flown.sticks.throttle),
                counts(flown.sticks.yaw)};
  out.refused_poses = e.refused_poses;
  out.orders = flown.orders;
  out.state = static_cast<std::uint8_t>(flown.supervised.failsafe_state);
  out.sent = flown.sent == core::Status::kOk ? 1 : 0;
  out.pose_new = newest_.pose.is_new ? 1 : 0;
  out.imu_new = a.is_new ? 1 : 0;
  return out;
}

template class FlightRecorder<float>;
template class FlightRecorder<double>;

}  // namespace m100::app
