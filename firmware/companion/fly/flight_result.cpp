// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/flight_result.h"

#include "firmware/companion/operator/link_report.h"
#include "firmware/companion/operator/operator_messages.h"

namespace m100::companion {
namespace {

Json steps_json(std::span<const safety::FailsafeStep> steps, const safety::Limits& limits) {
  Json out = Json::array();
  for (const safety::FailsafeStep& step : steps) {
    out.push_back({{"t_s", core::seconds<double>(step.seen.now.time_since_epoch())},
                   {"from", safety::name(step.from)},
                   {"to", safety::name(step.to)},
                   {"cause", safety::name(step.reason)},
                   {"seen", describe(step.reason, step.seen, limits).text()}});
  }
  return out;
}

Json to_json(const TrackingError& error) {
  return {{"rms_m", error.rms_m()},
          {"max_m", error.max_m()},
          {"horizontal_rms_m", error.horizontal_rms_m()},
          {"vertical_rms_m", error.vertical_rms_m()}};
}

Json to_json(const est::VibrationStatus& vibration) {
  return {{"rms_m_s2", vibration.rms_m_s2}, {"peak_m_s2", vibration.peak_m_s2}, {"clipped", vibration.clipped}};
}

Json to_json(const ctl::Excitation<double>& excitation, const ExcitationFile& file) {
  using State = ctl::Excitation<double>::State;
  const bool is_aborted = excitation.state() == State::kAborted;
  Json out{{"pieces", file.pieces.size()},
           {"flown", excitation.piece()},
           {"length_s", file.length_s()},
           {"from_s", core::seconds<double>(excitation.began().time_since_epoch())},
           {"to_s", core::seconds<double>(excitation.ended().time_since_epoch())},
           {"over", excitation.state() == State::kOver},
           {"aborted", is_aborted}};
  if (is_aborted) {
    out["abort"] = {{"why", ctl::Excitation<double>::name(excitation.abort())},
                    {"axis", name(excitation.axis())},
                    {"distance", excitation.distance()},
                    {"speed", excitation.speed()}};
  }
  return out;
}

}  // namespace

Json flight_result(const FlyOptions& options, const FlightFiles& orders, const FlightSequencer& sequencer,
                   const app::FlightController<double>& controller, std::uint32_t stalls,
                   const safety::Limits& limits) {
  const link::AuthorityView& authority = controller.link().authority();
  const est::Estimate<double>& estimate = controller.estimate();
  const FlightReporter& told = sequencer.reporter();
  Json out{{"channel", options.channel},
           {"baud", options.baud},
           {"mode", name(orders.flight->mode)},
           {"obtained", sequencer.flew()},
           {"released", sequencer.given_back()},
           {"took_off", sequencer.took_off()},
           {"landed", sequencer.landed()},
           {"last_stage", safety::name(authority.stage)},
           {"last_reason", safety::name(authority.reason)},
           {"failsafe", steps_json(told.steps(), limits)},
           {"checks_off", options.disabled_checks},
           {"stalls", stalls},
           {"tracking", to_json(told.tracking())},
           {"vibration", to_json(told.vibration())},
           {"position_m", {estimate.x.position_m, estimate.y.position_m, estimate.height_m}},
           {"health", companion::to_json(controller.link().health())}};
  if (told.limit_cycle()) {
    out["swinging"] = {{"t_s", core::seconds<double>(told.limit_cycle()->now.time_since_epoch())},
                       {"height_rad", told.limit_cycle()->limit_cycle.height_rad},
                       {"frequency_hz", told.limit_cycle()->limit_cycle.frequency_hz}};
  }
  if (orders.excitation) {
    out["excitation"] = to_json(controller.excitation(), *orders.excitation);
  }
  return out;
}

Json pose_result(const app::FlightController<double>& controller, const link::SignedLineStats* signatures,
                 std::span<const ClockStep> steps, const GroundStationStats& heard) {
  Json pose = pose_json(controller.pose_link());
  pose["clock_steps"] = Json::array();
  for (const ClockStep& step : steps) {
    pose["clock_steps"].push_back(
        {{"at_s", core::seconds<double>(step.at.time_since_epoch())}, {"by_s", core::seconds<double>(step.by)}});
  }
  return {{"pose", std::move(pose)},
          {"pose_link", companion::to_json(controller.pose_link().stats(), signatures)},
          {"ground_station",
           {{"goals", heard.goals},
            {"orders", heard.orders},
            {"orders_lost", heard.orders_lost},
            {"requests", heard.requests},
            {"requests_lost", heard.requests_lost}}}};
}

}  // namespace m100::companion
