// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/monitor/release_monitor.h"

namespace m100::companion {
namespace {

constexpr std::string_view kPilotAction = "PILOT: turn the mode switch to P and back to F";

constexpr std::string_view kPortAway =
    "the port is gone; control is not ours. It is opened again as soon as it is back";

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

void ReleaseMonitor::begin(core::TimePoint now, std::uint32_t stops) {
  begun_ = true;
  since_ = now;
  stops_before_ = stops;
  pilot_in_control_ = false;
}

ReleaseMonitor::State ReleaseMonitor::confirm_release(core::TimePoint now, const link::SerialLink& link,
                                                      std::uint32_t stops) {
  const link::AuthorityView& view = link.authority();
  if (now > since_ && !view.release_pending && !view.in_control && view.stage != safety::AuthorityStage::kReleasing) {
    report_holder(now, link);
    begun_ = false;
    return State::kReleased;
  }
  // Giving up without a confirmation: only if nothing of ours can arrive any more, or if the operator insists.
  const bool insists = stops > stops_before_ + (stops_before_ == 0 ? 1U : 0U);
  const bool port_is_lost = view.port_gone && now - port_seen_at_ > kPortTimeout;
  return port_is_lost || (insists && now - since_ > kReportDelay) ? State::kAbandoned : State::kPending;
}

void ReleaseMonitor::report_holder(core::TimePoint now, const link::SerialLink& link) {
  const link::AuthorityView& view = link.authority();
  const protocol::Telemetry& telemetry = link.telemetry();
  if (!view.link_alive) {
    operator_log_.write(now, "control was never ours, and nothing comes from the autopilot");
    return;
  }
  pilot_in_control_ =
      telemetry.control.device() == protocol::ControlDevice::kRemoteController && telemetry.rc.gear != 0;
  const bool is_certain = link.health().outages == outages_before_;
  operator_log_.write(now, !is_certain && pilot_in_control_
                               ? "telemetry at the port shows that the transmitter has control. The port was gone: if "
                                 "another autopilot was plugged in, this says nothing about the one that flew"
                               : whose(telemetry));
}

/// What keeps control from going back, for the operator; empty: nothing that is known.
std::string_view ReleaseMonitor::problem_of(core::TimePoint now, const link::AuthorityView& view) const {
  if (view.port_gone) {
    return view.release_pending ? "the port is gone: no byte of ours reaches the autopilot. " : kPortAway;
  }
  if (!view.release_pending) {
    return "";
  }
  if (!view.link_alive && !view.in_control) {
    return "nothing new comes from the autopilot; control is given back unconfirmed. ";
  }
  if (view.reason == safety::AuthorityReason::kUplinkSilent) {
    return "the autopilot answers nothing: no byte of ours reaches it. ";
  }
  return begun_ && now - since_ > kReportDelay ? "the autopilot does not show that the transmitter has control. " : "";
}

void ReleaseMonitor::update(core::TimePoint now, const link::AuthorityView& view) {
  port_seen_at_ = view.port_gone ? port_seen_at_ : now;
  const std::string_view problem = problem_of(now, view);
  if (problem != reported_ && problem == kPortAway) {
    operator_log_.write(now, problem);
  } else if (problem != reported_ && !problem.empty()) {
    operator_log_.write(
        now, TextLine{}.add(problem).add(kPilotAction).add(". The program keeps giving control back").text());
  }
  reported_ = problem;
}

}  // namespace m100::companion
