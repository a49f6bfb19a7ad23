// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "firmware/app/flight_controller.h"
#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/gains/gain_tables.h"
#include "host_tests/scenario/faults/announcing_uart.h"
#include "host_tests/sim/ports/world.h"

namespace m100::scenario {

using safety::FailsafeState;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// The whole flight controller hovering in the simulated world, one tick at a time. Records every quantity that promise
/// R12 bounds.
class FaultBench {
 public:
  explicit FaultBench(link::Channel channel = link::Channel::kVirtualRc, std::size_t log_bytes = 0,
                      const core::Fence& fence = {}, const sim::Plant& plant = sim::measured_plant(),
                      const link::LeverArm& stated_b_m = {}, const sim::WorldOptions& options = {.seed = 5})
      : world_(plant, options), log_storage_(std::max<std::size_t>(log_bytes, 1)) {
    start_.position_w_m = world_.vehicle().state().position_w_m;
    course_.hold(start_);
    app::FlightConfig config = app::kDefaultFlight;
    config.link.channel.channel = channel;
    config.link.app_id = 1;
    config.fence = fence;
    config.pose_offset_b_m = stated_b_m;
    controller_.emplace(mpc::generated::kVehicle, tables(), config, world_.autopilot_uart(), pose_, course_,
                        log_bytes == 0 ? nullptr : &log_);
  }

  /// One tick, late by `stall`.
  void tick(core::Duration stall = core::Duration{0}) {
    world_.advance(core::kTickPeriod + stall);
    static_cast<void>(controller_->tick(world_.now()));
    const core::Euler<double>& attitude = world_.vehicle().attitude();
    tilt_deg_ = std::max(
        tilt_deg_, std::acos(std::cos(attitude.roll_rad) * std::cos(attitude.pitch_rad)) * 180.0 / std::numbers::pi);
    if (commanding()) {
      const core::Vector<double, 3> off = world_.vehicle().state().position_w_m - start_.position_w_m;
      farthest_m_ = std::max(farthest_m_, off.norm());
      const bool by_law = safety::passes_law(failsafe_state());
      oldest_pose_ = std::max(oldest_pose_, by_law ? controller_->estimate().pose_age : core::Duration{0});
    }
  }
  void run(core::Duration time) {
    for (const core::TimePoint end = world_.now() + time; world_.now() < end;) {
      tick();
    }
  }
  /// Ticks until the failsafe is at `wanted`. @returns the time it took; empty if it took longer than `at_most`.
  std::optional<core::Duration> until(FailsafeState wanted, core::Duration at_most) {
    const core::TimePoint from = world_.now();
    while (failsafe_state() != wanted) {
      if (world_.now() - from >= at_most) {
        return std::nullopt;
      }
      tick();
    }
    return world_.now() - from;
  }
  /// Runs start-up, takes control and hovers for three seconds.
  bool take_off() {
    for (int i = 0; i < 1000 && controller_->link().authority().stage != safety::AuthorityStage::kReady; ++i) {
      tick();
    }
    controller_->engage();
    if (!until(FailsafeState::kNominal, seconds(10))) {
      return false;
    }
    run(seconds(3));
    return failsafe_state() == FailsafeState::kNominal;
  }
  /// Brings the failsafe from a hover to a state, by the fault or order that leads there.
  bool reach(FailsafeState wanted) {
    if (!take_off()) {
      return false;
    }
    if (wanted == FailsafeState::kCoast || wanted == FailsafeState::kLevel) {
      world_.pose_source().set_faults({.silent = true});
    } else if (wanted == FailsafeState::kRelease || wanted == FailsafeState::kSilent) {
      controller_->release();
    }
    return until(wanted, seconds(3)).has_value();
  }

  sim::World& world() { return world_; }
  AnnouncingUart& pose_line() { return pose_; }
  app::FlightController<double>& controller() { return *controller_; }
  log::FlightLogWriter& log() { return log_; }
  ref::Trajectory<double>& course() { return course_; }  ///< holds the position of the start
  const core::Vector<double, 3>& place() const { return start_.position_w_m; }
  FailsafeState failsafe_state() const { return controller_->grant().failsafe_state; }
  bool commanding() const { return controller_->grant().transmit; }
  const sim::N1Record& noted() { return world_.autopilot().record(); }
  double farthest_m() const { return farthest_m_; }  ///< from the hover point, while the program commands
  double tilt_deg() const { return tilt_deg_; }
  core::Duration oldest_pose() const {
    return oldest_pose_;
  }  ///< age of the oldest pose from which the law computed a command
  void forget_worst() { farthest_m_ = 0.0, oldest_pose_ = core::Duration{0}; }

  /// R12, at the end of every test: no hard touch, no large tilt, and nothing sent a period after a loss of control.
  bool is_sound(core::Duration command_period = milliseconds(40)) {
    return tilt_deg_ < 35.0 && world_.vehicle().touchdown_speed_m_s() < 1.0 &&
           noted().latest_after_loss <= command_period;
  }

 private:
  static const mpc::GainTables<double>& tables() {
    static const mpc::GainTables<double> made =
        lab::gains::make_gain_tables(mpc::generated::kVehicle, mpc::generated::kVehicleDigest);
    return made;
  }

  sim::World world_;
  AnnouncingUart pose_{world_.pose_uart()};
  ref::Waypoint<double> start_;
  ref::Trajectory<double> course_;
  std::vector<std::byte> log_storage_;
  log::Ring ring_{log_storage_};
  log::FlightLogWriter log_{ring_};
  std::optional<app::FlightController<double>> controller_;
  double farthest_m_ = 0.0;
  double tilt_deg_ = 0.0;
  core::Duration oldest_pose_{0};
};

}  // namespace m100::scenario
