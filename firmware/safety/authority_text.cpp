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
  AuthorityReason reason;
  std::string_view name;
  std::string_view remedy;
};

constexpr std::array kReasons{
    ReasonText{AuthorityReason::kNone, "none", ""},
    ReasonText{AuthorityReason::kStarting, "starting", "wait"},
    ReasonText{
        AuthorityReason::kNothingReceived, "nothing_heard",
        "no frame from the autopilot: check cable, power, port and baud rate, and tick \"enable API control\" in "
        "DJI's assistant"},
    ReasonText{AuthorityReason::kNoAnswer, "no_answer",
               "frames arrive but the autopilot does not answer: check the line towards it (TX), then ask again"},
    ReasonText{AuthorityReason::kAnswer, "answer", "see the remedy of the autopilot's answer"},
    ReasonText{AuthorityReason::kNotActivated, "not_activated",
               "the autopilot says that this program is not activated: ask again to activate it"},
    ReasonText{
        AuthorityReason::kNoRcItem, "no_rc_item",
        "telemetry lacks the RC or the control item: switch the remote controller on, and set both items in DJI's "
        "assistant to 50 Hz or more"},
    ReasonText{AuthorityReason::kNotModeF, "not_mode_f",
               "move the mode switch of the remote controller to F, then ask again"},
    ReasonText{AuthorityReason::kRcOff, "rc_off", "switch the remote controller on, then ask again"},
    ReasonText{AuthorityReason::kEndlessObtaining, "endless_obtaining",
               "someone else holds control: end missions and close the mobile app, wait ten seconds, then ask again"},
    ReasonText{AuthorityReason::kNotConfirmed, "not_confirmed",
               "the autopilot's answer and its telemetry disagree about who is in control; control is given back: ask "
               "again"},
    ReasonText{AuthorityReason::kVirtualRcRefused, "virtual_rc_refused",
               "Virtual RC cannot be switched on: move the mode switch out of F and back, then ask again"},
    ReasonText{AuthorityReason::kGranted, "granted", ""},
    ReasonText{AuthorityReason::kReleased, "released", ""},
    ReasonText{AuthorityReason::kRestarted, "restarted",
               "the autopilot restarted: check that it works, then ask again"},
    ReasonText{AuthorityReason::kControlLost, "control_lost",
               "the autopilot took control away (mode switch, mobile app, or no transmitter): ask again when the pilot "
               "agrees"},
    ReasonText{AuthorityReason::kLinkSilent, "link_silent", "telemetry stopped: check the cable, then ask again"},
    ReasonText{AuthorityReason::kLeftModeF, "left_mode_f",
               "the pilot moved the mode switch out of F: move it back to F, then ask again"},
    ReasonText{AuthorityReason::kTaken, "taken",
               "the remote controller or the mobile app is in control: ask again when the pilot agrees"},
    ReasonText{
        AuthorityReason::kVirtualRcEnded, "virtual_rc_ended",
        "the autopilot ended Virtual RC (no data for a second, or the pilot's sticks); control is given back: ask "
        "again"},
    ReasonText{
        AuthorityReason::kOwnStall, "own_stall",
        "this program stalled for more than half a second; control is given back: find the cause (m100 doctor), then "
        "ask again"},
    ReasonText{AuthorityReason::kUplinkSilent, "unheard",
               "the autopilot no longer answers: our bytes do not reach it (check the line towards it, TX); control is "
               "given back: ask again"},
    ReasonText{AuthorityReason::kPortBack, "port_back",
               "the port is back and start-up begins anew: control is taken only after you ask again"},
};

constexpr bool in_order() {
  for (std::size_t i = 0; i < kReasons.size(); ++i) {
    if (static_cast<std::size_t>(kReasons[i].reason) != i) {
      return false;
    }
  }
  return kReasons.back().reason == AuthorityReason::kPortBack && kStageNames.back() == "silent_cold";
}
static_assert(in_order());

}  // namespace

std::string_view name(AuthorityStage stage) { return kStageNames[static_cast<std::size_t>(stage)]; }
std::string_view name(AuthorityReason reason) { return kReasons[static_cast<std::size_t>(reason)].name; }
std::string_view remedy(AuthorityReason reason) { return kReasons[static_cast<std::size_t>(reason)].remedy; }

}  // namespace m100::safety
