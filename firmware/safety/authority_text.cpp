// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cstddef>

#include "firmware/safety/authority.h"

namespace m100::safety {
namespace {

constexpr std::array<std::string_view, kStageCount> kStageNames{
    "listening",          "asking_version", "activating", "setting_rates", "pausing",
    "awaiting_telemetry", "ready",          "obtaining",  "spacing",       "confirming",
    "enabling",           "in_control",     "releasing",  "silent",        "silent_cold"};

struct ReasonText {
  Reason reason;
  std::string_view name;
  std::string_view remedy;
};

constexpr std::array kReasons{
    ReasonText{Reason::kNone, "none", ""},
    ReasonText{Reason::kStarting, "starting", "wait"},
    ReasonText{
        Reason::kNothingHeard, "nothing_heard",
        "no frame from the autopilot: check cable, power, port and baud rate, and tick \"enable API control\" in "
        "DJI's assistant"},
    ReasonText{Reason::kNoAnswer, "no_answer",
               "frames arrive but the autopilot does not answer: check the line towards it (TX), then ask again"},
    ReasonText{Reason::kAnswer, "answer", "see the remedy of the autopilot's answer"},
    ReasonText{Reason::kNotActivated, "not_activated",
               "the autopilot says that this program is not activated: ask again to activate it"},
    ReasonText{
        Reason::kNoRcItem, "no_rc_item",
        "telemetry lacks the RC or the control item: switch the remote controller on, and set both items in DJI's "
        "assistant to 50 Hz or more"},
    ReasonText{Reason::kNotModeF, "not_mode_f", "move the mode switch of the remote controller to F, then ask again"},
    ReasonText{Reason::kRcOff, "rc_off", "switch the remote controller on, then ask again"},
    ReasonText{Reason::kEndlessObtaining, "endless_obtaining",
               "someone else holds control: end missions and close the mobile app, wait ten seconds, then ask again"},
    ReasonText{Reason::kNotConfirmed, "not_confirmed",
               "the autopilot's answer and its telemetry disagree about who is in control; control is given back: ask "
               "again"},
    ReasonText{Reason::kVirtualRcRefused, "virtual_rc_refused",
               "Virtual RC cannot be switched on: move the mode switch out of F and back, then ask again"},
    ReasonText{Reason::kGranted, "granted", ""},
    ReasonText{Reason::kReleased, "released", ""},
    ReasonText{Reason::kRestarted, "restarted", "the autopilot restarted: check that it works, then ask again"},
    ReasonText{Reason::kControlLost, "control_lost",
               "the autopilot took control away (mode switch, mobile app, or no transmitter): ask again when the pilot "
               "agrees"},
    ReasonText{Reason::kLinkSilent, "link_silent", "telemetry stopped: check the cable, then ask again"},
    ReasonText{Reason::kLeftModeF, "left_mode_f",
               "the pilot moved the mode switch out of F: move it back to F, then ask again"},
    ReasonText{Reason::kTaken, "taken",
               "the remote controller or the mobile app is in control: ask again when the pilot agrees"},
    ReasonText{
        Reason::kVirtualRcEnded, "virtual_rc_ended",
        "the autopilot ended Virtual RC (no data for a second, or the pilot's sticks); control is given back: ask "
        "again"},
    ReasonText{
        Reason::kOwnStall, "own_stall",
        "this program stalled for more than half a second; control is given back: find the cause (m100 doctor), then "
        "ask again"},
    ReasonText{Reason::kUnheard, "unheard",
               "the autopilot no longer answers: our bytes do not reach it (check the line towards it, TX); control is "
               "given back: ask again"},
    ReasonText{Reason::kPortBack, "port_back",
               "the port is back and start-up begins anew: control is taken only after you ask again"},
};

constexpr bool in_order() {
  for (std::size_t i = 0; i < kReasons.size(); ++i) {
    if (static_cast<std::size_t>(kReasons[i].reason) != i) {
      return false;
    }
  }
  return kReasons.back().reason == Reason::kPortBack && kStageNames.back() == "silent_cold";
}
static_assert(in_order());

}  // namespace

std::string_view name(Stage stage) { return kStageNames[static_cast<std::size_t>(stage)]; }
std::string_view name(Reason reason) { return kReasons[static_cast<std::size_t>(reason)].name; }
std::string_view remedy(Reason reason) { return kReasons[static_cast<std::size_t>(reason)].remedy; }

}  // namespace m100::safety
