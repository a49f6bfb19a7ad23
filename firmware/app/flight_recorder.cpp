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

}  // namespace

template <typename T>
log::TickRecord logged(const TickRecord<T>& record, std::uint32_t dropped_messages) {
  const est::Estimate<T>& e = record.estimate;
  const auto& [x, y, z] = record.reference;
  const auto& a = record.measured.attitude;
  log::TickRecord out;
  out.timestamp = static_cast<std::uint64_t>(record.now.time_since_epoch().count());
  out.position = numbers_of(e.x.position_m, e.y.position_m, e.height_m);
  out.velocity = numbers_of(e.x.velocity_m_s, e.y.velocity_m_s, e.climb_m_s);
  out.attitude = numbers_of(e.y.tilt_rad, e.x.tilt_rad, e.yaw_rad);
  out.tilt_rate = numbers_of(e.y.tilt_rate_rad_s, e.x.tilt_rate_rad_s);
  out.disturbance = numbers_of(e.x.disturbance_m_s2, e.y.disturbance_m_s2);
  out.input_offset = numbers_of(e.x.input_offset_rad, e.y.input_offset_rad);
  out.climb_offset = static_cast<double>(e.climb_offset_m_s);
  out.ref_position = numbers_of(x.position_m, y.position_m, z.position_m);
  out.ref_velocity = numbers_of(x.velocity_m_s, y.velocity_m_s, z.velocity_m_s);
  out.ref_acceleration = numbers_of(x.acceleration_m_s2, y.acceleration_m_s2);
  out.ref_yaw = static_cast<double>(record.reference_yaw_rad);
  const auto& p = record.measured.pose.position_w_m;
  out.pose_position = numbers_of(p.x(), p.y(), p.z());
  out.pose_yaw = static_cast<double>(record.measured.pose.yaw_rad);
  out.imu_attitude = numbers_of(a.roll_rad, a.pitch_rad, a.yaw_rad);
  out.imu_rate = numbers_of(a.rate_b_rad_s.x(), a.rate_b_rad_s.y(), a.rate_b_rad_s.z());
  out.wanted = numbers(record.wanted);
  out.granted = numbers(record.supervised.command);
  out.pose_age = core::seconds<float>(e.pose_age);
  out.telemetry_age = core::seconds<float>(record.health.telemetry_age);
  out.late = core::seconds<float>(record.elapsed - core::kTickPeriod);
  out.residual = static_cast<float>(record.residual);
  out.sticks = {counts(record.sticks.roll), counts(record.sticks.pitch), counts(record.sticks.throttle),
                counts(record.sticks.yaw)};
  out.facts = static_cast<std::uint32_t>(record.conditions);
  out.refused_poses = e.refused_poses;
  out.dropped_messages = dropped_messages;
  out.state = static_cast<std::uint8_t>(record.supervised.failsafe_state);
  out.sent = record.sent == core::Status::kOk ? 1 : 0;
  out.pose_new = record.measured.pose.is_new ? 1 : 0;
  out.imu_new = a.is_new ? 1 : 0;
  out.link_state = static_cast<std::uint8_t>(record.authority.stage);
  out.mpc_path_x = static_cast<std::uint8_t>(record.law.path_x);
  out.mpc_path_y = static_cast<std::uint8_t>(record.law.path_y);
  out.mpc_changes = static_cast<std::uint8_t>(record.law.changes < 255U ? record.law.changes : 255U);
  out.orders = record.orders;
  return out;
}

template <typename T>
std::optional<log::ExcitationRecord> logged(const ctl::Excitation<T>& excitation, core::TimePoint now) {
  if (excitation.state() == ctl::Excitation<T>::State::kIdle) {
    return {};
  }
  return log::ExcitationRecord{.timestamp = static_cast<std::uint64_t>(now.time_since_epoch().count()),
                               .distance = static_cast<float>(excitation.distance()),
                               .speed = static_cast<float>(excitation.speed()),
                               .counts = static_cast<std::int16_t>(excitation.counts()),
                               .sample = static_cast<std::uint16_t>(excitation.sample()),
                               .piece = static_cast<std::uint8_t>(excitation.piece()),
                               .axis = static_cast<std::uint8_t>(excitation.axis()),
                               .state = static_cast<std::uint8_t>(excitation.state()),
                               .abort = static_cast<std::uint8_t>(excitation.abort())};
}

template std::optional<log::ExcitationRecord> logged(const ctl::Excitation<float>& excitation, core::TimePoint now);
template std::optional<log::ExcitationRecord> logged(const ctl::Excitation<double>& excitation, core::TimePoint now);
template log::TickRecord logged(const TickRecord<float>& record, std::uint32_t dropped_messages);
template log::TickRecord logged(const TickRecord<double>& record, std::uint32_t dropped_messages);

}  // namespace m100::app
