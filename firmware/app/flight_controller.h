// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/app/config.h"
#include "firmware/app/measure.h"
#include "firmware/app/pose_trust.h"
#include "firmware/ctl/braking.h"
#include "firmware/ctl/design_scale.h"
#include "firmware/ctl/excitation.h"
#include "firmware/ctl/fence_keeper.h"
#include "firmware/ctl/flight_law.h"
#include "firmware/ctl/place_watch.h"
#include "firmware/ctl/swing_answer.h"
#include "firmware/est/disturbance_ekf.h"
#include "firmware/est/pose_timing.h"
#include "firmware/est/trim_watch.h"
#include "firmware/link/pose_link.h"
#include "firmware/link/serial_link.h"
#include "firmware/log/flight_log.h"
#include "firmware/model/vehicle.h"
#include "firmware/mpc/gain_table.h"
#include "firmware/ref/trajectory.h"
#include "firmware/safety/supervisor.h"
#include "firmware/sysid/residual_monitor.h"
#include "firmware/vrc/command_map.h"
#include "hal/uart.h"

namespace m100::app {

/// Tick timing.
struct TickStats {
  std::uint32_t ticks = 0;
  std::uint32_t stalls = 0;  ///< more than two periods since the last tick (R9); the ladder sees the old pose
  core::Duration longest{0};
};

/// Writes the bytes that pass a link into the flight log.
class LogTap final : public link::ByteTap {
 public:
  LogTap(log::FlightLogWriter* log, log::Stream in, log::Stream out) : log_(log), in_(in), out_(out) {}
  void received(std::span<const std::byte> bytes, core::TimePoint now) override { append(in_, bytes, now); }
  void sent(std::span<const std::byte> bytes, core::TimePoint now) override { append(out_, bytes, now); }

 private:
  void append(log::Stream stream, std::span<const std::byte> bytes, core::TimePoint now) {
    if (log_ != nullptr) {
      log_->append(stream, now, bytes);
    }
  }
  log::FlightLogWriter* log_;
  log::Stream in_;
  log::Stream out_;
};

/// The flight program: one tick is one function, and each step of the data flow is one of its lines.
///
/// T is the scalar of control and estimate (float or double), S that of the observer (T, or core::Fixed). Nothing is
/// allocated, nothing waits, nothing reads a clock. Cost: firmware/README.md.
template <typename T, typename S = T>
class FlightController {
 public:
  /// All arguments must outlive the controller. @param log may be null.
  FlightController(const model::Vehicle& vehicle, const mpc::GainTables<T>& tables, const FlightConfig& config,
                   hal::Uart& autopilot, hal::Uart& pose, ref::Trajectory<T>& trajectory, log::FlightLogWriter* log);

  /// One period of 10 ms; `now` is never before that of the last one. @returns the result of the command: see
  ///   SerialLink::send; kRefused: silent by the ladder.
  core::Status tick(core::TimePoint now);

  /// The operator's two orders. engage(): control is requested as the protocol requires, and the ladder may step up;
  /// the trajectory begins when it does. No effect while the law already flies. release(): neutral sticks, then control
  /// goes back to the pilot. Both take effect in the next tick and are logged in its record.
  void engage() { orders_ |= log::kOrderEngage; }
  void release() { orders_ |= log::kOrderRelease; }

  /// Take-off and landing by the autopilot's own tasks, by the operator's order. `task_flies` is valid for the next
  /// tick only; call it before each tick for as long as the autopilot flies its task. The ladder is at level then, with
  /// sticks that brake and hold, or that rest during a take-off. `begin_task` sends the request to the autopilot, once.
  /// Another part watches the task, so an image without tasks contains no code for it.
  void task_flies(protocol::Task task) {
    orders_ |= task == protocol::Task::kTakeOff ? log::kOrderTakesOff : log::kOrderLands;
  }
  /// @returns as SerialLink::request.
  core::Status begin_task(protocol::Task task) {
    orders_ |= log::kOrderTask;
    return link_.request({.sequence = ++tasks_, .task = task}, last_tick_);
  }

  const link::SerialLink& link() const { return link_; }
  const link::PoseLink& pose_link() const { return pose_link_; }
  const safety::Supervisor<T>& supervisor() const { return supervisor_; }
  const est::Estimate<T>& estimate() const { return estimate_; }
  /// The poses have been compared with the autopilot for long enough to notice a body that moves by itself.
  bool has_looked() const { return trust_.has_looked(); }
  const ref::Window<T>& reference() const { return reference_; }
  const safety::Grant<T>& grant() const { return grant_; }
  /// The supervisor's inputs of the last tick.
  const safety::Observation& observed() const { return observed_; }
  const MeasureStats& measure_stats() const { return measure_.stats(); }
  /// Timing of the poses: latency, jitter, and how much older they are than their time stamps say.
  const est::PoseTimingReport<T>& pose_timing() const { return timing_.report(); }
  est::EkfCounters observer_counters() const { return observer_.counters(); }
  const ctl::FlightLaw<T>& law() const { return law_; }
  const ctl::Excitation<T>& excitation() const { return excitation_; }
  /// Whether the aircraft still answers its sticks as the vehicle file says; Virtual RC only.
  const sysid::ResidualMonitor<T>& residual() const { return residual_; }
  /// How far the balancing points have moved from the vehicle file's; Virtual RC only.
  const est::TrimReport<T>& trim() const { return trim_.report(); }
  /// Whether the autopilot's telemetry contradicts the poses.
  est::Contradiction<T> contradiction() const { return trust_.contradiction(); }
  const TickStats& stats() const { return stats_; }
  /// When the ladder last reached its top from silence or level: where the trajectory's time began.
  core::TimePoint started() const { return started_; }

 private:
  void note_time(core::TimePoint now);
  void take_orders(core::TimePoint now);
  bool is_in_reach() const;
  core::Pose<double> pose(core::TimePoint now);
  /// The command of the level rung: it brakes, then holds.
  ctl::Command<T> settled() const;
  safety::Observation observation(core::TimePoint now);
  void give_back_unused(core::TimePoint now);
  /// Resets course and integral in every tick in which the law does not fly, because the ladder steps up only after the
  /// law has computed the command that then leaves.
  void stand_ready(core::TimePoint now);
  /// Whether the programs are solved in this tick: in each, unless FlightConfig::solves_when_due is set.
  bool may_leave(core::TimePoint now) const;
  safety::Grant<T> granted(bool solved);
  void start_when_nominal(safety::Rung before, core::TimePoint now);
  bool levels_a_swing() const;
  void excite(core::TimePoint now);
  vrc::Stick excited_stick() const;
  vrc::Sticks excited(vrc::Sticks mapped) const;
  core::Status send(const safety::Grant<T>& grant, core::TimePoint now);
  core::Status tell(const ctl::Command<T>& command, core::TimePoint now);
  ctl::Command<T> pilots_command(const protocol::Telemetry& telemetry) const;
  void remember(const est::Measurement<T>& measured);
  void watch_residual();
  log::TickRecord record(core::TimePoint now, core::Status sent) const;
  log::ExcitationRecord excitation_record(core::TimePoint now) const;

  LogTap autopilot_tap_;
  LogTap pose_tap_;
  link::SerialLink link_;
  link::PoseLink pose_link_;
  Measure measure_;
  est::PoseTiming<T> timing_;
  est::DisturbanceEkf<S, T> observer_;
  PoseTrust<T> trust_;
  ref::Trajectory<T>& trajectory_;
  ctl::FlightLaw<T> law_;
  ctl::DesignScale<T> design_;
  ctl::Braking braking_;
  ctl::FenceKeeper<T> fence_;
  ctl::PlaceWatch<T> place_;
  ctl::SwingAnswer<T> swing_;
  ctl::Excitation<T> excitation_;
  safety::Supervisor<T> supervisor_;
  vrc::CommandMap commands_;
  sysid::ResidualMonitor<T> residual_;
  est::TrimWatch<T> trim_;
  log::FlightLogWriter* log_;
  FlightConfig config_;

  est::Measurement<T> measured_;  ///< newest pose and attitude; is_new of this tick
  est::Estimate<T> estimate_;
  ref::Window<T> reference_;
  ctl::Command<T> wanted_{};  ///< of the law, in every tick; its tilts as last solved
  safety::Observation observed_;
  safety::Grant<T> grant_;
  ctl::Command<T> in_force_{};  ///< command last sent to the autopilot, after rounding to its stick counts
  vrc::Sticks last_sticks_{};
  core::TimePoint last_tick_{};
  core::Duration elapsed_ = core::kTickPeriod;
  core::Duration slew_time_{0};  ///< since the granted command last changed
  core::TimePoint started_{};
  core::TimePoint order_until_{};
  bool order_stands_ = false;  ///< as of this tick
  core::TimePoint unused_since_{};
  std::uint32_t orders_ = 0;       ///< given since the last tick
  std::uint32_t tick_orders_ = 0;  ///< that this tick acts upon
  std::uint8_t tasks_ = 0;         ///< requested so far: their number on the wire
  TickStats stats_;
};

}  // namespace m100::app
