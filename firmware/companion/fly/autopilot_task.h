// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/fly/text_line.h"
#include "protocol/commands.h"

namespace m100::companion {

/// Whether the aircraft is on the ground, by the flight status item of telemetry. An item older than two seconds does
/// not count.
struct GroundView {
  bool known = false;
  bool on_ground = false;
  GroundView(const link::SerialLink& link, core::TimePoint now);
};

/// A take-off or a landing by the autopilot's own task (protocol, 6.3), from the operator's order to its end. It sends
/// one request, at least two seconds after the last one. The answer and the flight status item of telemetry show the
/// outcome. A landing waits until the aircraft is slow, for 2.5 s at most, because the task flies level and does not
/// brake. The ladder stands at level meanwhile, so that the pilot's switch, a silent autopilot and the operator's stop
/// end the task as they end a flight; a lost pose does not, because the task needs none. No heap, no clock.
class AutopilotTask {
 public:
  using Controller = app::FlightController<double>;
  enum class State : std::uint8_t { kNone, kWaits, kAsked, kFlies, kDone, kFailed };
  enum class Failure : std::uint8_t {
    kNone,
    kRefused,    ///< by the autopilot; its code is in answer()
    kNoAnswer,   ///< no answer, and the flight status does not show the task
    kNotAsked,   ///< the request could not be sent
    kNotBegun,   ///< accepted, but the flight status does not change
    kBrokenOff,  ///< the flight status returned to where the task began
    kTooLong,
  };
  static constexpr core::Duration kSpacing = std::chrono::seconds(2);  ///< between two requests
  static constexpr core::Duration kSlowIn = std::chrono::milliseconds(2500);
  static constexpr double kSlow_m_s = 0.3;
  static constexpr core::Duration kAnswerIn = std::chrono::seconds(1);
  static constexpr core::Duration kBegunIn = std::chrono::seconds(5);
  static constexpr core::Duration kSettled = std::chrono::milliseconds(500);  ///< in the air for so long: taken off
  static constexpr core::Duration kBrokenFor = std::chrono::seconds(1);
  static constexpr core::Duration kTakeOffIn = std::chrono::seconds(20);
  static constexpr core::Duration kLandingIn = std::chrono::seconds(90);

  /// Begins a task on the operator's order; a landing may replace a take-off that is not over.
  void order(protocol::Task task, core::TimePoint now);
  /// Call it after each tick of the controller while control is ours.
  /// @returns the state; after kDone and kFailed the task no longer acts on the controller.
  State tick(core::TimePoint now, Controller& controller);

  protocol::Task task() const { return task_; }
  Failure failure() const { return failure_; }
  /// The autopilot's answer, if it refused.
  const protocol::AckMeaning& answer() const { return answer_; }

 private:
  bool may_ask(core::TimePoint now, const Controller& controller) const;
  void ask(core::TimePoint now, Controller& controller);
  void hear_answer(core::TimePoint now, const Controller& controller);
  void watch(core::TimePoint now, const link::SerialLink& link);
  void fail(Failure failure);

  protocol::Task task_ = protocol::Task::kLand;
  State state_ = State::kNone;
  Failure failure_ = Failure::kNone;
  protocol::AckMeaning answer_{};
  core::TimePoint ordered_at_{};
  core::TimePoint asked_at_{-kSpacing};
  core::TimePoint same_since_{};  ///< when the flight status last changed
  protocol::FlightStatus status_ = protocol::FlightStatus::kMotorsOff;
  bool begun_ = false;
};

/// "take-off" or "landing".
std::string_view name(protocol::Task task);
/// Adds the reason of a failure, with the autopilot's code.
void describe(TextLine& line, const AutopilotTask& task);

}  // namespace m100::companion
