// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/flight_monitors.h"

#include "firmware/app/tick_timer.h"

namespace m100::app {

template <typename T>
[[gnu::cold]] FlightMonitors<T>::FlightMonitors(const model::Vehicle& vehicle, const ctl::Braking& braking,
                                                core::Duration attitude_delay, bool responds)
    : authority_(braking),
      limit_cycle_(braking, responds),
      residual_(vehicle, typename sysid::ResidualMonitor<T>::Expected{}, core::seconds<T>(core::kTickPeriod),
                core::seconds<T>(attitude_delay)),
      trim_(vehicle) {}

template <typename T>
void FlightMonitors<T>::update(const est::Estimate<T>& estimate, const ref::Window<T>& reference, bool flies,
                               bool excited, core::Duration elapsed, ctl::FlightLaw<T>& law) {
  authority_.update(estimate, reference, flies, core::seconds<T>(elapsed));
  limit_cycle_.update(estimate, reference, flies, excited, core::seconds<T>(elapsed), law);
}

template <typename T>
void FlightMonitors<T>::update_model(const est::Measurement<T>& measured, const est::Estimate<T>& estimate,
                                     const vrc::Sticks& sticks, bool flies_sticks, bool holds, core::Duration elapsed) {
  trim_.update(estimate, flies_sticks && holds, core::seconds<T>(elapsed));
  const Attitude attitude = measured.attitude.is_new ? measured.attitude : attitude_;
  attitude_ = measured.attitude;
  if (!flies_sticks || !attitude.is_new || elapsed > TickTimer::kStall) {
    residual_.interrupt();
    return;
  }
  const auto counts = [](vrc::Stick stick) { return static_cast<T>(static_cast<int>(stick) - 1024); };
  // In the order of sysid::MonitoredAxis; the yaw stick is positive to the right. The gyro's z rate is the heading's
  // rate only while the aircraft is level: at 20 degrees of roll it includes a third of the pitch rate.
  const core::SinCos<T>& roll = attitude.roll();
  const T heading_rate_rad_s =
      (roll.sine * attitude.rate_b_rad_s.y() + roll.cosine * attitude.rate_b_rad_s.z()) / attitude.pitch().cosine;
  const est::TrimCounts<T>& trim = trim_.now();
  residual_.update({.stick_counts = {counts(sticks.roll) - trim.roll, counts(sticks.pitch) - trim.pitch,
                                     counts(sticks.yaw), counts(sticks.throttle)},
                    .measured = {attitude.roll_rad, attitude.pitch_rad, -heading_rate_rad_s, estimate.climb_m_s}});
}

template <typename T>
sysid::ModelStatus FlightMonitors<T>::model() const {
  return {.mismatch = {residual_.report(sysid::MonitoredAxis::kRoll).departed,
                       residual_.report(sysid::MonitoredAxis::kPitch).departed,
                       residual_.report(sysid::MonitoredAxis::kYawRate).departed,
                       residual_.report(sysid::MonitoredAxis::kClimb).departed},
          .trim_drifted = trim_.report().drifted};
}

template class FlightMonitors<float>;
template class FlightMonitors<double>;

}  // namespace m100::app
