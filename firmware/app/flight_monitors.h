// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/app/flight_state_monitor.h"
#include "firmware/ctl/law/braking.h"
#include "firmware/ctl/monitor/control_authority_monitor.h"
#include "firmware/ctl/monitor/limit_cycle_response.h"
#include "firmware/est/measurement.h"
#include "firmware/est/trim_monitor.h"
#include "firmware/sysid/model_status.h"
#include "firmware/sysid/residual_monitor.h"
#include "firmware/vrc/stick_map.h"

namespace m100::app {

/// The monitors of a flight: whether it still flies, strong wind, limit cycle, trim, residual of the vehicle's model.
/// T is float or double.
template <typename T>
class FlightMonitors {
 public:
  /// @param attitude_delay from sending a stick to reading the attitude that it gives, without the vehicle's own delay.
  ///   @param responds false: limit cycles are neither reported nor answered.
  FlightMonitors(const model::Vehicle& vehicle, const ctl::Braking& braking, core::Duration attitude_delay,
                 bool responds);

  /// Once per tick, after the law; may start its fallback. @param flies whether the law flies. @param excited whether
  /// an excitation moves a stick.
  void update(const est::Estimate<T>& estimate, const ref::Window<T>& reference, bool flies, bool excited,
              core::Duration elapsed, ctl::FlightLaw<T>& law);
  /// Once per tick, after the fault isolation, see FlightStateMonitor.
  void update_flight_state(const link::SerialLink& link, const est::Estimate<T>& estimate,
                           const core::Vector<T, 2>& model_tilt_rad, const FaultIsolation<T>& isolation,
                           core::Duration elapsed) {
    flight_state_.update(link, estimate, model_tilt_rad, isolation, elapsed);
  }
  /// Once per tick, after the sticks were sent. @param flies_sticks the aircraft obeys our sticks. @param holds see
  /// FlightController. If no attitude comes in one tick, the residual uses that of
  /// the tick before.
  void update_model(const est::Measurement<T>& measured, const est::Estimate<T>& estimate, const vrc::Sticks& sticks,
                    bool flies_sticks, bool holds, core::Duration elapsed);

  ctl::ControlAuthorityStatus wind() const { return authority_.status(); }
  ctl::LimitCycleStatus limit_cycle() const { return limit_cycle_.status(); }
  bool limit_cycle_persists() const { return limit_cycle_.persists(); }
  safety::FlightState flight_state() const { return flight_state_.status(); }
  sysid::ModelStatus model() const;
  const sysid::ResidualMonitor<T>& residual() const { return residual_; }
  const est::TrimMonitor<T>& trim() const { return trim_; }

 private:
  using Attitude = typename est::Measurement<T>::Attitude;
  FlightStateMonitor<T> flight_state_;
  ctl::ControlAuthorityMonitor<T> authority_;
  ctl::LimitCycleResponse<T> limit_cycle_;
  sysid::ResidualMonitor<T> residual_;
  est::TrimMonitor<T> trim_;
  Attitude attitude_;  ///< of the tick before; is_new is true if it came in that tick
};

extern template class FlightMonitors<float>;
extern template class FlightMonitors<double>;

}  // namespace m100::app
