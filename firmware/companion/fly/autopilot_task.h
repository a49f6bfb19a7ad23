// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/fly/text_line.h"
#include "protocol/commands.h"

namespace m100::companion {

/// What the flight status item of telemetry says. Nothing counts that is older than two seconds.
struct GroundView {
  bool known = false;
  bool on_ground = false;
  GroundView(const link::SerialLink& link, core::TimePoint now);
};

/// A take-off or a landing by the autopilot's own task (protocol, 6.3), from the operator's order to its end. It asks
/// once, and never sooner than two seconds after it asked last; the answer and the flight status item of telemetry say
/// what became of it. A landing waits until the aircraft is slow, for 2.5 s at most: the task flies level and brakes
/// nothing. The ladder stands at level meanwhile, so that the pilot's switch, a silent autopilot and the operator's
/// stop end it as they end everything; a lost pose does not, because the task needs none. No heap, no clock.
class AutopilotTask {
 public:
  using Controller = app::FlightController<double>;
  enum class State : std::uint8_t { kNone, kWaits, kAsked, kFlies, kDone, kFailed };
  enum class Failure : std::uint8_t {
    kNone,
    kRefused,    ///< the autopilot says so: its code is in answer()
    kNoAnswer,   ///< and the flight status shows nothing of it
    kNotAsked,   ///< the request could not leave
    kNotBegun,   ///< accepted, and the flight status does not change
    kBrokenOff,  ///< the flight status goes back to what it was
    kTooLong,
  };
  static constexpr core::Duration kSpacing = std::chrono::seconds(2);  ///< between two requests
  static constexpr core::Duration kSlowIn = std::chrono::milliseconds(2500);
  static constexpr double kSlow_m_s = 0.3;
  static constexpr core::Duration kAnswerIn = std::chrono::seconds(1);
  static constexpr core::Duration kBegunIn = std::chrono::seconds(5);
  static constexpr core::Duration kSettled = std::chrono::milliseconds(500);  ///< in the air, before it has taken off
  static constexpr core::Duration kBrokenFor = std::chrono::seconds(1);
  static constexpr core::Duration kTakeOffIn = std::chrono::seconds(20);
  static constexpr core::Duration kLandingIn = std::chrono::seconds(90);

  /// The operator's order; a landing may follow upon a take-off that is not over.
  void order(protocol::Task task, core::TimePoint now);
  /// After each tick of the controller while control is ours. @returns where it stands; behind kDone and kFailed
  ///   nothing is said to the controller any more.
  State tick(core::TimePoint now, Controller& controller);

  protocol::Task task() const { return task_; }
  Failure failure() const { return failure_; }
  /// The autopilot's answer, where it was refused.
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
  core::TimePoint same_since_{};  ///< the flight status is what it is
  protocol::FlightStatus status_ = protocol::FlightStatus::kMotorsOff;
  bool begun_ = false;
};

/// "take-off" or "landing".
std::string_view name(protocol::Task task);
/// Why it failed, with the autopilot's code, in words.
void describe(TextLine& line, const AutopilotTask& task);

}  // namespace m100::companion
