// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/operator/text_line.h"
#include "firmware/core/fence.h"
#include "protocol/dji/commands.h"

namespace m100::companion {

/// Whether the aircraft is on the ground, by the flight status item of telemetry; nullopt: the item is older than two
/// seconds.
std::optional<bool> is_on_ground(const link::SerialLink& link, core::TimePoint now);

/// A take-off or a landing by the autopilot's own task (protocol, 6.3), from the operator's order to its end. It sends
/// one request, at least two seconds after that of the task before. The answer and the flight status item of telemetry
/// show the outcome. The request to land waits until the aircraft is slow, at most 2.5 s, because the autopilot's task
/// does not brake: it holds the attitude, and a wind carries the aircraft away. So a landing is not requested if, by
/// the present speed and the estimated wind, its touch-down would be too fast, and a task that drifts is ended. To end
/// a take-off, control must go to the pilot for two seconds (protocol, 5). The take-off is shorter, so it is flown on
/// unless it leaves the fence. No heap.
class AutopilotTask {
 public:
  using Controller = app::FlightController<double>;
  enum class State : std::uint8_t { kNone, kWaiting, kRequested, kActive, kDone, kWouldDrift, kFailed };
  enum class Failure : std::uint8_t {
    kNone,
    kRefused,     ///< by the autopilot; its code is in answer()
    kNoAnswer,    ///< no answer, and the flight status does not show the task
    kNotSent,     ///< the request could not be sent
    kNotStarted,  ///< accepted, but the flight status does not change
    kAborted,     ///< the flight status returned to that before the task
    kTimeout,
    kDrifted,  ///< the aircraft left its place, or its fence
  };
  static constexpr core::Duration kRequestInterval = std::chrono::seconds(2);  ///< least, between two requests
  static constexpr core::Duration kSlowDownTimeout = std::chrono::milliseconds(2500);
  static constexpr double kMaxLandingSpeed_m_s = 0.3;

  /// @param fence whose sides end a take-off that drifts; its floor and ceiling do not count
  /// @param ground_z_m of the flight file; the place of a take-off replaces it
  AutopilotTask(const core::Fence& fence, double ground_z_m) : fence_(fence), ground_z_m_(ground_z_m) {}

  /// Begins a task on the operator's order; a landing may replace a take-off that is not over.
  void start(protocol::Task task, core::TimePoint now);
  /// Call it after each tick of the controller while control is ours.
  /// @returns the state; after kDone, kWouldDrift and kFailed the task no longer acts on the controller.
  State tick(core::TimePoint now, Controller& controller);

  protocol::Task task() const { return task_; }
  State state() const { return state_; }
  /// The autopilot flies the task, or may: our commands have no effect.
  bool is_flown() const { return state_ == State::kRequested || state_ == State::kActive; }
  Failure failure() const { return failure_; }
  /// The autopilot's answer, if it refused.
  const protocol::AckMeaning& answer() const { return answer_; }

 private:
  bool may_request(core::TimePoint now, const Controller& controller) const;
  void send_request(core::TimePoint now, Controller& controller);
  void update_answer(core::TimePoint now, const Controller& controller);
  void update_status(core::TimePoint now, const link::SerialLink& link);
  bool in_air(const Controller& controller) const;
  bool drifts(core::TimePoint now, const Controller& controller);
  double touch_down_m_s(const Controller& controller) const;
  void fail(Failure failure);

  core::Fence fence_;
  double ground_z_m_;
  protocol::Task task_ = protocol::Task::kLand;
  State state_ = State::kNone;
  Failure failure_ = Failure::kNone;
  protocol::AckMeaning answer_{};
  core::TimePoint started_at_{};
  core::TimePoint requested_at_{-kRequestInterval};
  /// Of the estimate when the task was requested, or first known after that.
  std::optional<core::Vector<double, 3>> from_w_m_;
  std::uint32_t resets_ = 0;      ///< of the estimate, when `from_w_m_` was noted
  core::TimePoint slow_since_{};  ///< when the speed sideways was last small enough for a touch-down
  core::TimePoint same_since_{};  ///< when the flight status last changed since the request
  protocol::FlightStatus status_ = protocol::FlightStatus::kMotorsOff;
  bool begun_ = false;
};

/// "take-off" or "landing".
std::string_view name(protocol::Task task);
/// The task and why it failed; after a refusal, with the autopilot's code.
TextLine describe(const AutopilotTask& task);

}  // namespace m100::companion
