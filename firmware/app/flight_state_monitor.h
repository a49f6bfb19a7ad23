// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/app/fault_isolation.h"
#include "firmware/est/estimate.h"
#include "firmware/link/serial_link.h"
#include "firmware/safety/failure_detector.h"
#include "firmware/safety/ground_contact.h"

namespace m100::app {

/// Reads from telemetry whether the aircraft still flies: on the ground by the autopilot's own status, or out of
/// control by FailureDetector. T is float or double. No heap.
template <typename T>
class FlightStateMonitor {
 public:
  /// Once per tick, after the fault isolation.
  /// @param model_tilt_rad along x and y, predicted from the commands by the observer's model
  void update(const link::SerialLink& link, const est::Estimate<T>& estimate, const core::Vector<T, 2>& model_tilt_rad,
              const FaultIsolation<T>& isolation, core::Duration elapsed);
  safety::FlightState status() const { return {.on_ground_for = ground_contact_.duration(), .failure = failure_}; }

 private:
  safety::FailureDetector<T> detector_;
  safety::GroundContact ground_contact_;
  safety::FlightFailure failure_ = safety::FlightFailure::kNone;
  /// The last known unit of the specific force: in a free fall its mean length leaves the range that shows the unit.
  T force_scale_m_s2_{0};
};

extern template class FlightStateMonitor<float>;
extern template class FlightStateMonitor<double>;

}  // namespace m100::app
