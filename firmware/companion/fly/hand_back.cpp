// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/hand_back.h"

namespace m100::companion {
namespace {

constexpr std::string_view kPilotsPart = "PILOT: turn the mode switch to P and back to F";

/// Who has control, by telemetry that shows that it is not ours.
std::string_view whose(const protocol::Telemetry& telemetry) {
  if (telemetry.control.device() == protocol::ControlDevice::kMobileApp) {
    return "the mobile app has control of the aircraft, not the transmitter: end its control there, or turn the mode "
           "switch to P and back to F";
  }
  if (telemetry.rc.gear == 0) {
    return "control is not ours, and no transmitter is heard: it is off or out of range, and the autopilot does what "
           "it is configured to do in that case. PILOT: switch the transmitter on";
  }
  return "the transmitter has the aircraft";
}

}  // namespace

void HandBack::begin(core::TimePoint now, std::uint32_t stops) {
  begun_ = true;
  since_ = now;
  stops_before_ = stops;
  is_with_the_pilot_ = false;
}

HandBack::State HandBack::look(core::TimePoint now, const link::SerialLink& link, std::uint32_t stops) {
  const link::AuthorityView& view = link.authority();
  if (now > since_ && !view.owed && !view.in_control && view.stage != safety::Stage::kReleasing) {
    tell_whose(now, link);
    begun_ = false;
    return State::kOver;
  }
  // Giving up without a confirmation: only if nothing of ours can arrive any more, or if the operator insists.
  const bool insists = stops > stops_before_ + (stops_before_ == 0 ? 1U : 0U);
  const bool port_is_lost = view.port_gone && now - port_here_ > kPortReturns;
  return port_is_lost || (insists && now - since_ > kTold) ? State::kGivesUp : State::kGoesOn;
}

void HandBack::tell_whose(core::TimePoint now, const link::SerialLink& link) {
  const link::AuthorityView& view = link.authority();
  const protocol::Telemetry& telemetry = link.telemetry();
  if (!view.heard) {
    listener_.hear(now, "control was never ours, and nothing comes from the autopilot");
    return;
  }
  is_with_the_pilot_ =
      telemetry.control.device() == protocol::ControlDevice::kRemoteController && telemetry.rc.gear != 0;
  const bool is_certain = link.health().outages == outages_before_;
  listener_.hear(now, !is_certain && is_with_the_pilot_
                          ? "telemetry at the port shows that the transmitter has control. The port was gone: if "
                            "another autopilot was plugged in, this says nothing about the one that flew"
                          : whose(telemetry));
}

HandBack::Trouble HandBack::trouble_of(core::TimePoint now, const link::AuthorityView& view) const {
  if (view.port_gone) {
    return view.owed ? Trouble::kPortGone : Trouble::kPortAway;
  }
  if (!view.owed) {
    return Trouble::kNone;
  }
  if (!view.heard && !view.in_control) {
    return Trouble::kNothingHeard;
  }
  if (view.reason == safety::Reason::kUnheard) {
    return Trouble::kUnheard;
  }
  return begun_ && now - since_ > kTold ? Trouble::kStillOurs : Trouble::kNone;
}

void HandBack::watch(core::TimePoint now, const link::AuthorityView& view) {
  port_here_ = view.port_gone ? port_here_ : now;
  const Trouble trouble = trouble_of(now, view);
  if (trouble != told_ && trouble == Trouble::kPortAway) {
    listener_.hear(now, "the port is gone; control is not ours. It is opened again as soon as it is back");
  } else if (trouble != told_ && trouble != Trouble::kNone) {
    TextLine line;
    line.add(trouble == Trouble::kPortGone ? "the port is gone: no byte of ours reaches the autopilot. "
             : trouble == Trouble::kNothingHeard
                 ? "nothing new comes from the autopilot; control is given back unconfirmed. "
             : trouble == Trouble::kUnheard ? "the autopilot answers nothing: no byte of ours reaches it. "
                                            : "the autopilot does not show that the transmitter has control. ");
    listener_.hear(now, line.add(kPilotsPart).add(". The program keeps giving control back").text());
  }
  told_ = trouble;
}

}  // namespace m100::companion
