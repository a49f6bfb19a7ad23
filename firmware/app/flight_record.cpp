// SPDX-License-Identifier: BSD-3-Clause
// The log records of a tick.
#include "firmware/app/flight_controller.h"

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

template <typename T, typename S>
log::TickRecord FlightController<T, S>::record(core::TimePoint now, core::Status sent) const {
  const est::Estimate<T>& e = estimate_;
  const ref::Window<T>& r = reference_;
  log::TickRecord out;
  out.timestamp = static_cast<std::uint64_t>(now.time_since_epoch().count());
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
  const auto& p = measured_.pose.position_w_m;
  out.pose_position = numbers_of(p.x(), p.y(), p.z());
  out.pose_yaw = static_cast<double>(measured_.pose.yaw_rad);
  const auto& a = measured_.attitude;
  out.imu_attitude = numbers_of(a.roll_rad, a.pitch_rad, a.yaw_rad);
  out.imu_rate = numbers_of(a.rate_b_rad_s.x(), a.rate_b_rad_s.y(), a.rate_b_rad_s.z());
  out.wanted = numbers(commanded_);
  out.granted = numbers(supervised_.command);
  out.pose_age = core::seconds<float>(e.pose_age);
  out.telemetry_age = core::seconds<float>(link_.health().telemetry_age);
  out.late = core::seconds<float>(elapsed_ - core::kTickPeriod);
  out.sticks = {counts(last_sticks_.roll), counts(last_sticks_.pitch), counts(last_sticks_.throttle),
                counts(last_sticks_.yaw)};
  out.facts = static_cast<std::uint32_t>(supervisor_.conditions());
  out.refused_poses = e.refused_poses;
  out.dropped_messages = log_ != nullptr ? log_->dropped() : 0U;
  out.residual = static_cast<float>(residual_.report(residual_.worst()).ratio);
  out.orders = tick_orders_;
  out.state = static_cast<std::uint8_t>(supervised_.failsafe_state);
  out.sent = sent == core::Status::kOk ? 1 : 0;
  out.pose_new = measured_.pose.is_new ? 1 : 0;
  out.imu_new = a.is_new ? 1 : 0;
  out.link_state = static_cast<std::uint8_t>(link_.authority().stage);
  out.mpc_path_x = static_cast<std::uint8_t>(law_.report().path_x);
  out.mpc_path_y = static_cast<std::uint8_t>(law_.report().path_y);
  out.mpc_changes = static_cast<std::uint8_t>(law_.report().changes < 255U ? law_.report().changes : 255U);
  return out;
}

template <typename T, typename S>
log::ExcitationRecord FlightController<T, S>::excitation_record(core::TimePoint now) const {
  return {.timestamp = static_cast<std::uint64_t>(now.time_since_epoch().count()),
          .distance = static_cast<float>(excitation_.distance()),
          .speed = static_cast<float>(excitation_.speed()),
          .counts = static_cast<std::int16_t>(excitation_.counts()),
          .sample = static_cast<std::uint16_t>(excitation_.sample()),
          .piece = static_cast<std::uint8_t>(excitation_.piece()),
          .axis = static_cast<std::uint8_t>(excitation_.axis()),
          .state = static_cast<std::uint8_t>(excitation_.state()),
          .abort = static_cast<std::uint8_t>(excitation_.abort())};
}

template log::ExcitationRecord FlightController<double>::excitation_record(core::TimePoint) const;
template log::ExcitationRecord FlightController<float>::excitation_record(core::TimePoint) const;
template log::ExcitationRecord FlightController<float, core::Fixed>::excitation_record(core::TimePoint) const;
template log::TickRecord FlightController<double>::record(core::TimePoint, core::Status) const;
template log::TickRecord FlightController<float>::record(core::TimePoint, core::Status) const;
template log::TickRecord FlightController<float, core::Fixed>::record(core::TimePoint, core::Status) const;

}  // namespace m100::app
