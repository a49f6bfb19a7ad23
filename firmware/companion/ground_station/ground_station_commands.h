// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/fly/flight_sequencer.h"
#include "firmware/companion/ground_station/guided_mode.h"
#include "firmware/companion/ground_station/telemetry_stream.h"
#include "firmware/companion/operator/operator_input.h"

namespace m100::companion {

/// Handles what comes from the ground station. Goals change the course. An order to engage or release has the effect of
/// the operator's command. Each order is answered; an unknown one is refused and reported by its number. No heap.
class GroundStationCommands {
 public:
  /// @param settings nullopt: the flight takes no goals, see goal_settings(). @param telemetry_stream null: there are
  /// no
  ///   answers.
  GroundStationCommands(const std::optional<GoalSettings>& settings, const core::Fence& fence,
                        ref::Trajectory<double>& trajectory, GroundStationTap& line, TelemetryStream* telemetry_stream,
                        OperatorLog& operator_log)
      : line_(line), telemetry_stream_(telemetry_stream), operator_log_(operator_log) {
    if (settings) {
      follower_.emplace(trajectory, fence, *settings);
    }
  }

  /// Call it after each tick of the controller. @returns the ground station's commands in the operator's place.
  OperatorInput tick(core::TimePoint now, const app::FlightController<double>& controller,
                     const SequencerStatus& status);
  /// Whether goals, or an order to hold, have led the flight.
  bool has_goal() const { return follower_ && follower_->goals.goal().has_value(); }

 private:
  static constexpr core::Duration kGoalReportInterval = std::chrono::seconds(1);  ///< between two lines about goals

  OperatorInput execute(core::TimePoint now, const GroundStationTap::Order& order, bool holds,
                        const SequencerStatus& status);
  void report_goal(core::TimePoint now, GoalResult answer);
  /// A repeated answer gives one line; goals, and answers that alternate, one each per kGoalReportInterval.
  bool is_new(core::TimePoint now, GoalResult answer) const;
  void send(const Reply& reply);

  std::optional<GoalFollower<double>> follower_;
  GroundStationTap& line_;
  TelemetryStream* telemetry_stream_;
  OperatorLog& operator_log_;
  std::optional<GoalResult> reported_;
  std::array<core::TimePoint, kGoalResults> reported_at_{};
};

}  // namespace m100::companion
