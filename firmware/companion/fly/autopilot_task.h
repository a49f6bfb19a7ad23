// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/operator/text_line.h"
#include "firmware/core/fence.h"
#include "protocol/dji/commands.h"

namespace m100::companion {

/// Whether the aircraft is on the ground, by the flight status item of telemetry. An item older than two seconds does
/// not count.
struct LandedState {
  bool known = false;
  bool on_ground = false;
  LandedState(const link::SerialLink& link, core::TimePoint now);
};

/// A take-off or a landing by the autopilot's own task (protocol, 6.3), from the operator's order to its end. It sends
/// one request, at least two seconds after that of the task before. The answer and the flight status item of telemetry
/// show the outcome. The request to land waits until the aircraft is slow, at most 2.5 s, because the autopilot's task
/// does not brake: it holds the attitude, and a wind carries the aircraft away. So a landing is not requested if the
/// estimated wind would make its touch-down too fast, and a task that drifts is ended. A take-off can only be ended
/// into the pilot's hands for more than two seconds (protocol, 5), in which it would drift on. It is flown to its end,
/// which takes less, unless it leaves the fence. No heap.
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

  /// @param fence whose sides end a take-off that drifts; its floor and ceiling do not count.
  explicit AutopilotTask(const core::Fence& fence) : fence_(fence) {}

  /// Begins a task on the operator's order; a landing may replace a take-off that is not over.
  void start(protocol::Task task, core::TimePoint now);
  /// Call it after each tick of the controller while control is ours.
  /// @returns the state; after kDone, kWouldDrift and kFailed the task no longer acts on the controller.
  State tick(core::TimePoint now, Controller& controller);

  protocol::Task task() const { return task_; }
  State state() const { return state_; }
  Failure failure() const { return failure_; }
  /// The autopilot's answer, if it refused.
  const protocol::AckMeaning& answer() const { return answer_; }

 private:
  bool may_request(core::TimePoint now, const Controller& controller) const;
  void send_request(core::TimePoint now, Controller& controller);
  void update_answer(core::TimePoint now, const Controller& controller);
  void update_status(core::TimePoint now, const link::SerialLink& link);
  bool in_air(const Controller& controller) const;
  bool drifts(const Controller& controller) const;
  double touch_down_m_s(const Controller& controller) const;
  void fail(Failure failure);

  core::Fence fence_;
  protocol::Task task_ = protocol::Task::kLand;
  State state_ = State::kNone;
  Failure failure_ = Failure::kNone;
  protocol::AckMeaning answer_{};
  core::TimePoint started_at_{};
  core::TimePoint requested_at_{-kRequestInterval};
  core::Vector<double, 3> requested_from_m_{0.0, 0.0, 0.0};
  double ground_m_ = 0.0;         ///< height of the last take-off; otherwise the world's floor
  core::TimePoint same_since_{};  ///< when the flight status last changed since the request
  protocol::FlightStatus status_ = protocol::FlightStatus::kMotorsOff;
  bool begun_ = false;
};

/// "take-off" or "landing".
std::string_view name(protocol::Task task);
/// Adds the task and why it failed; after a refusal, with the autopilot's code.
void describe(TextLine& line, const AutopilotTask& task);

}  // namespace m100::companion
