// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/flight_state_monitor.h"

#include "firmware/app/sensor_adapter.h"
#include "firmware/core/maths.h"
#include "firmware/model/vehicle.h"

namespace m100::app {
namespace {

constexpr float kMaxForce = 400.F;  ///< larger than any sensor's range, in g or in m/s^2

template <typename T>
core::Vector<T, 3> flu(const std::array<float, 3>& frd) {
  return {static_cast<T>(frd[0]), -static_cast<T>(frd[1]), -static_cast<T>(frd[2])};
}

}  // namespace

template <typename T>
void FlightStateMonitor<T>::update(const link::SerialLink& link, const est::Estimate<T>& estimate,
                                   const core::Vector<T, 2>& model_tilt_rad, const FaultIsolation<T>& isolation,
                                   core::Duration elapsed) {
  using protocol::TelemetryItem;
  const protocol::Telemetry& telemetry = link.telemetry();
  ground_contact_.update(protocol::is_on_ground(telemetry.flight_status), isolation.poses_read_high(),
                         link.received_at(TelemetryItem::kFlightStatus));
  const core::Vector<T, 2> lean_rad(estimate.x.tilt_rad - model_tilt_rad.x(), estimate.y.tilt_rad - model_tilt_rad.y());
  safety::FlightSample<T> sample{.attitude_is_trusted = !isolation.attitude_is_contradicted(),
                                 .lean_rad = core::sqrt(lean_rad.squaredNorm())};
  if (telemetry.has(TelemetryItem::kAngularVelocity)) {
    sample.up_b = SensorAdapter::vertical_b<T>(telemetry);
    sample.rate_b_rad_s = flu<T>(telemetry.angular_velocity_frd_rad_s);
  }
  force_scale_m_s2_ = isolation.force_scale_m_s2() > T(0) ? isolation.force_scale_m_s2() : force_scale_m_s2_;
  const core::Vector<T, 3> force = flu<T>(telemetry.acceleration);
  const T force2 = force.squaredNorm();
  if (telemetry.has(TelemetryItem::kAcceleration) && force_scale_m_s2_ > T(0) &&
      force2 < static_cast<T>(kMaxForce * kMaxForce)) {
    sample.force_g = core::sqrt(force2) * force_scale_m_s2_ * static_cast<T>(1.0 / model::kGravity_m_s2);
  }
  const float down_m_s = telemetry.velocity_ned_m_s[2];
  if (telemetry.has(TelemetryItem::kVelocity) && (down_m_s < 0.F || down_m_s > 0.F)) {
    sample.climb_m_s = -static_cast<T>(down_m_s);
  }
  failure_ = detector_.update(sample, core::seconds<T>(elapsed));
}

template class FlightStateMonitor<float>;
template class FlightStateMonitor<double>;

}  // namespace m100::app
