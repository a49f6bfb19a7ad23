// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/fly/autopilot_task.h"
#include "firmware/companion/fly/hand_back.h"
#include "firmware/companion/fly/listener.h"
#include "firmware/companion/fly/text_line.h"
#include "firmware/companion/room/homeward.h"

namespace m100::companion {

/// What the operator wants of a flight.
struct Wishes {
  bool take_control = false;  ///< request control once, as soon as everything is ready
  double hold_s = 5.0;        ///< with take_control: after this time give back and end
  bool once = false;          ///< for scripts: end where the program would wait for the operator
  bool take_off = false;      ///< a command to fly, given on the ground, takes off first, by the autopilot's own task
  bool land = false;          ///< land at the end of hold_s, likewise, instead of giving control back in the air
  core::Vector<double, 3> begins_w_m = core::Vector<double, 3>::Zero();  ///< where the course begins, in the world
  /// Where the aircraft stands before a take-off.
  core::Vector<double, 3> stands_w_m = core::Vector<double, 3>::Zero();
  double reach_m = 1e9;  ///< control is not requested farther from there: the law would fly the distance at once
  HomeSettings home{};   ///< a low battery ends the flight where its course begins
  double home_yaw_rad = 0.0;
};

/// What the operator did since the last tick.
struct OperatorInput {
  bool word = false;        ///< Enter, or SIGUSR1
  bool land = false;        ///< "land", typed, or by a signed order
  std::uint32_t stops = 0;  ///< signals to end, so far
  bool guarded = true;      ///< the second process gives control back if this program dies
  bool led = false;  ///< goals have led the flight: the next flight begins where the aircraft is, not at its course
};

/// The operator's part of a flight (promise R15). One command takes control when everything is ready, another gives it
/// back. A refusal or a release by the ladder does not end the program: it tells what was seen and waits for the
/// operator's next command. The program ends only when telemetry shows that the transmitter has the aircraft, or when
/// the port is gone. A take-off precedes the flight and a landing follows it, each only on its own order. A command, a
/// stop and the pilot's switch end them as they end a flight; if the autopilot refuses one, control goes back. No heap.
class Pilotage {
 public:
  static constexpr std::size_t kSteps = 64;  ///< steps of the ladder that are kept: the first ones

  /// @param trajectory the controller's: a low battery changes it.
  Pilotage(const Wishes& wishes, const app::FlightConfig& config, app::FlightController<double>& controller,
           ref::Trajectory<double>& trajectory, Listener& listener)
      : wishes_(wishes),
        limits_(config.limits),
        controller_(controller),
        listener_(listener),
        home_(trajectory, config.fence, {.position_w_m = wishes.begins_w_m, .yaw_rad = wishes.home_yaw_rad},
              wishes.home),
        back_(listener) {}

  /// Call it after each tick. @returns false: the flight is over.
  bool tick(core::TimePoint now, const OperatorInput& input);

  bool flew() const { return flew_; }
  /// Control was not requested: a command would request it.
  bool waits() const { return phase_ == Phase::kWaiting; }
  /// A command would have no effect.
  bool hands_back() const { return phase_ == Phase::kHandingBack; }
  /// A command would take off: control is not ours, and the aircraft stands on the ground.
  bool would_take_off(core::TimePoint now) const { return waits() && takes_off_from_here(now); }
  void end_or_fly_on(core::TimePoint now, const OperatorInput& input);
  /// An order to land would be served.
  bool may_land() const;
  /// A take-off or landing by the autopilot is in progress, or control is requested for a take-off.
  bool in_task(protocol::Task task) const {
    const bool is_asked_for = phase_ == Phase::kAsking && takes_off_ && task == protocol::Task::kTakeOff;
    return is_asked_for || (phase_ == Phase::kTask && task_.task() == task);
  }
  /// The battery is low, and the aircraft flies to where the flight began, or is there.
  bool goes_home() const { return home_.state() != Homeward<double>::State::kNotYet; }
  bool took_off() const { return took_off_; }
  bool landed() const { return landed_; }
  /// Control was ours, the operator ended it, and the transmitter has the aircraft.
  bool given_back() const { return given_back_; }
  /// The observation when the first swing was noticed (safety::Observation::swings); empty: none was.
  const std::optional<safety::Observation>& swing() const { return swing_; }
  std::span<const safety::LadderStep> steps() const { return std::span(steps_).first(step_count_); }

 private:
  enum class Phase { kWaiting, kAsking, kTask, kFlying, kHandingBack };
  using View = link::AuthorityView;
  static constexpr std::string_view kAgain = "Enter (or SIGUSR1) asks for control again, Ctrl-C ends the program";
  static constexpr std::string_view kOver = "--once: the program ends; start it again to ask for control again";

  bool wait(core::TimePoint now, const View& view, const OperatorInput& input);
  bool ask(core::TimePoint now, const View& view, const OperatorInput& input);
  bool fly(core::TimePoint now, const View& view, const OperatorInput& input);
  bool fly_task(core::TimePoint now, const View& view, const OperatorInput& input);
  void begin_task(core::TimePoint now, protocol::Task task);
  void end_task(core::TimePoint now, const OperatorInput& input);
  bool hand_back(core::TimePoint now, const View& view, const OperatorInput& input);
  void try_to_engage(core::TimePoint now, bool guarded);
  bool takes_off_from_here(core::TimePoint now) const;
  safety::Cause obstacle_now(bool takes_off) const;
  bool is_outside(bool takes_off) const;
  bool is_out_of_reach(bool takes_off) const;
  /// The law must not take over here: farther from the beginning of the course than its reach, or outside the fence.
  bool is_elsewhere(bool takes_off) const { return is_outside(takes_off) || is_out_of_reach(takes_off); }
  /// What the operator may do next; ends a line that says why control is not taken now.
  std::string_view next_word(bool ends_with_once) const { return ends_with_once && wishes_.once ? kOver : kAgain; }
  void tell_reach(core::TimePoint now, bool takes_off);
  void tell_place(core::TimePoint now, bool takes_off);
  void tell_obstacle(core::TimePoint now, safety::Cause cause);
  void begin_hand_back(core::TimePoint now, bool by_operator, const OperatorInput& input);
  bool is_refused(core::TimePoint now, const View& view) const;
  void tell_stage(core::TimePoint now, const View& view);
  void tell_ladder(core::TimePoint now);
  void tell_excitation(core::TimePoint now);
  void tell_swing(core::TimePoint now);
  void tell_home(core::TimePoint now);
  void tell_end(core::TimePoint now, const View& view);
  void tell_what_is_awaited(core::TimePoint now, const View& view);
  void tell(core::TimePoint now, std::string_view what) { listener_.hear(now, what); }

  Wishes wishes_;
  safety::Limits limits_;
  app::FlightController<double>& controller_;
  Listener& listener_;
  Homeward<double> home_;
  Homeward<double>::State told_home_ = Homeward<double>::State::kNotYet;
  AutopilotTask task_;
  Phase phase_ = Phase::kWaiting;
  core::TimePoint since_{};  ///< begin of the phase
  HandBack back_;
  bool takes_off_ = false;    ///< the flight that was requested begins with a take-off
  bool had_control_ = false;  ///< since the last request
  bool order_given_ = false;  ///< the order of take_control
  bool engaged_ = false;      ///< the law flew in this flight
  bool by_operator_ = false;
  bool led_ = false;   ///< OperatorInput::led of this tick
  bool ends_ = false;  ///< the program ends when the hand-back is over
  bool flew_ = false;
  bool took_off_ = false;
  bool landed_ = false;
  bool given_back_ = false;
  core::TimePoint clear_{};                     ///< when only the operator's command was missing
  std::optional<core::TimePoint> waits_since_;  ///< for start-up, or for an obstacle to go away
  safety::Cause told_obstacle_ = safety::Cause::kNone;
  bool told_stage_ = false;
  ctl::Excitation<double>::State told_excitation_ = ctl::Excitation<double>::State::kIdle;
  bool told_swing_ = false;
  std::optional<safety::Observation> swing_;
  safety::Stage last_stage_ = safety::Stage::kListening;
  safety::Reason last_reason_ = safety::Reason::kNone;
  std::uint32_t told_steps_ = 0;
  std::array<safety::LadderStep, kSteps> steps_{};
  std::size_t step_count_ = 0;
};

}  // namespace m100::companion
