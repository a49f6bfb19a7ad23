// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/app/command_sender.h"
#include "firmware/app/config.h"
#include "firmware/app/fault_isolation.h"
#include "firmware/app/flight_monitors.h"
#include "firmware/app/flight_recorder.h"
#include "firmware/app/operator_orders.h"
#include "firmware/app/pose_input.h"
#include "firmware/app/sensor_adapter.h"
#include "firmware/app/tick_record.h"
#include "firmware/app/tick_timer.h"
#include "firmware/ctl/design_scale.h"
#include "firmware/ctl/excitation.h"
#include "firmware/ctl/law/braking.h"
#include "firmware/ctl/law/flight_law.h"
#include "firmware/ctl/law/geofence_limiter.h"
#include "firmware/est/filter/disturbance_ekf.h"
#include "firmware/link/serial_link.h"
#include "firmware/log/flight_log.h"
#include "firmware/model/vehicle.h"
#include "firmware/mpc/gain_table.h"
#include "firmware/ref/trajectory.h"
#include "firmware/safety/supervisor.h"
#include "hal/uart.h"

namespace m100::app {

/// The flight program: one tick is four calls, and each step of the data flow is a line of one of them.
///
/// T is the scalar of control and estimate (float or double), S that of the observer (T, or core::Fixed). Nothing is
/// allocated, nothing waits, nothing reads a clock. Cost: firmware/RESULTS.md.
template <typename T, typename S = T>
class FlightController {
 public:
  /// All arguments must outlive the controller. @param log may be null.
  FlightController(const model::Vehicle& vehicle, const mpc::GainTables<T>& tables, const FlightConfig& config,
                   hal::Uart& autopilot, hal::Uart& pose, ref::Trajectory<T>& trajectory, log::FlightLogWriter* log);

  /// One period of 10 ms; `now` is never before that of the last one. @returns as CommandSender::send.
  core::Status tick(core::TimePoint now);

  /// The operator's two orders. engage(): control is requested as the protocol requires, and the failsafe may enter
  /// kNominal, at which the trajectory begins. No effect while the law already flies, or out of reach. release(): the
  /// command of kRelease for half a second, then control goes back; in kSilent at once. Both act in the next tick.
  void engage() { orders_.add(log::kOrderEngage); }
  void release() { orders_.add(log::kOrderRelease); }

  /// Reports that the autopilot flies its own take-off or landing. It is valid for the next tick only: call it before
  /// each of these ticks. The failsafe is then in kLevel. @param in_air its command brakes and holds, so that the
  /// aircraft brakes as soon as the autopilot obeys our commands again; false: neutral, because the aircraft may stand
  /// on the ground.
  void task_flies(bool in_air) { orders_.add(in_air ? log::kOrderLands : log::kOrderTakesOff); }
  /// Ends a task: control goes back at once, because a command of kRelease would have no effect.
  void end_task() { orders_.add(log::kOrderLands | log::kOrderRelease); }
  /// Instead of a landing: the law hovers where the aircraft is (GoalPlanner::stay).
  void hover_here() { orders_.add(log::kOrderLands | log::kOrderEngage); }
  bool hovers_here() const { return orders_.hovers_here(); }  ///< ordered for the last tick
  /// Requests a task of the autopilot. The link repeats it twice if no answer comes. @returns as SerialLink::request.
  core::Status begin_task(protocol::Task task) { return orders_.begin_task(task, link_, timer_.last()); }

  /// All of the last tick in one copy, valid until the next one.
  const TickRecord<T>& record();
  const link::SerialLink& link() const { return link_; }
  const link::PoseLink& pose_link() const { return poses_.link(); }
  const safety::Supervisor<T>& supervisor() const { return supervisor_; }
  const est::Estimate<T>& estimate() const { return estimate_; }
  /// Whether poses and specific force have been compared for long enough to detect a false motion, or cannot be.
  bool is_converged() const { return fault_isolation_.is_converged(); }
  const ref::Window<T>& reference() const { return reference_; }
  const safety::SupervisedCommand<T>& grant() const { return record_.supervised; }
  /// The supervisor's inputs of the last tick.
  const safety::Observation& observed() const { return supervisor_.observed(); }
  const SensorAdapterStats& sensor_stats() const { return sensors_.stats(); }
  /// Timing of the poses: latency, jitter, and what is known of their sender's clock.
  const est::PoseTimingReport<T>& pose_timing() const { return poses_.timing(); }
  est::EkfCounters observer_counters() const { return observer_.counters(); }
  const ctl::FlightLaw<T>& law() const { return law_; }
  const ctl::Excitation<T>& excitation() const { return excitation_; }
  /// Whether the aircraft still answers its sticks as the vehicle file says; Virtual RC only.
  const sysid::ResidualMonitor<T>& residual() const { return monitors_.residual(); }
  /// How far the trims have moved from the vehicle file's; Virtual RC only.
  const est::TrimReport<T>& trim() const { return monitors_.trim().report(); }
  /// The check that contradicts the poses or the attitude, if any does.
  est::Contradiction<T> contradiction() const { return fault_isolation_.contradiction(); }
  /// By how much the autopilot's heading turned without its gyroscopes and the poses; zero: it does not.
  T heading_turned_alone_rad() const { return fault_isolation_.heading_turned_alone_rad(); }
  /// The world of the pose source. Estimate and reference stay in the one in which the flight began.
  const SourceFrame<T>& source_frame() const { return poses_.source_frame(); }
  const TickStats& stats() const { return timer_.stats(); }
  /// When the failsafe last reached NOMINAL from SILENT or LEVEL: there the trajectory began.
  core::TimePoint started() const { return orders_.served(); }

 private:
  /// What a tick begins with.
  struct Sensed {
    const protocol::Telemetry& telemetry;
    ctl::Command<T> acting;  ///< the command that the autopilot obeys now, in the observer's scale
    est::Measurement<T> measured;
  };
  /// What the law and the excitation want.
  struct Wanted {
    ctl::Command<T> command;
    bool may_leave = false;
  };

  Sensed sense(core::TimePoint now);   ///< bytes -> telemetry and pose -> measurement
  void observe(const Sensed& sensed);  ///< observer; then: does each sensor agree with the others?
  Wanted command(const ctl::Command<T>& acting, core::TimePoint now);  ///< reference, plan, fence, law, excitation
  /// The supervisor may only restrict what is wanted; then sticks, bytes and the record. @returns as tick.
  core::Status act(const Wanted& wanted, const est::Measurement<T>& measured, core::TimePoint now);

  bool flies() const { return safety::passes_law(supervisor_.failsafe_state()); }
  est::HeadingReset heading_reset() const;
  bool is_in_reach() const;
  est::Measurement<T> adapt(const protocol::Telemetry& telemetry, core::TimePoint now);
  /// Whether the nominal flight holds its place: the reference is constant, no excitation moves a stick, no limit
  /// cycle has led to the fallback law, and the poses are trusted.
  bool holds() const;
  /// Moves what TrimMonitor learned in this tick from the estimated input offset to the sticks' neutrals.
  void apply_learned_trims();
  /// Resets course and law in every tick in which the law does not fly, so that both are new in the tick in which the
  /// failsafe lets it fly. In kCoast and after a stall it postpones the course.
  void prepare_start(core::TimePoint now);
  /// While the law flies: replaces the jump to a set point by a motion, unless the configuration or an excitation
  /// forbids it.
  void plan(core::TimePoint now, std::size_t points);
  /// Limits the reference to the fence. Not inlined: its copy of the estimate leaves the stack before the law solves.
  void hold_fence(core::TimePoint now, std::size_t points);
  /// Whether a command of this tick may leave. False only while the law flies in control, without its fallback, and the
  /// link is not due.
  bool may_leave(core::TimePoint now) const;
  /// @returns the law's command; on the axis that the excitation moves, the excitation's.
  ctl::Command<T> excite(ctl::Command<T> commanded, core::TimePoint now);
  bool levels_limit_cycle() const;
  /// The command of the level state: it brakes, then holds. It is neutral during a take-off by the autopilot's task.
  ctl::Command<T> brake_and_hold() const;
  safety::SupervisedCommand<T> supervise(const Wanted& wanted, core::TimePoint now);
  void start_when_nominal(safety::FailsafeState before, core::TimePoint now);

  TickTimer timer_;
  OperatorOrders orders_;
  FlightRecorder recorder_;
  link::SerialLink link_;
  PoseInput<T> poses_;
  SensorAdapter sensors_;
  est::DisturbanceEkf<S, T> observer_;
  FaultIsolation<T> fault_isolation_;
  ref::Trajectory<T>& trajectory_;
  ctl::FlightLaw<T> law_;
  ctl::DesignScale<T> design_;
  ctl::GeofenceLimiter<T> geofence_;
  ctl::Excitation<T> excitation_;
  FlightMonitors<T> monitors_;
  safety::Supervisor<T> supervisor_;
  CommandSender<T> sender_;
  FlightConfig config_;

  const est::Estimate<T>& estimate_ = observer_.estimate();
  ref::Window<T> reference_;  ///< beyond its first point only valid in a tick that solves
  TickRecord<T> record_;      ///< complete after record()
};

}  // namespace m100::app
