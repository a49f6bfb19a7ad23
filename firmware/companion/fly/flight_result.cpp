// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/flight_result.h"

#include <nlohmann/json.hpp>

#include "firmware/companion/fly/excitation.h"
#include "firmware/companion/fly/link_report.h"
#include "firmware/companion/fly/words.h"

namespace m100::companion {
namespace {

nlohmann::json steps_json(const Pilotage& pilotage, const safety::Limits& limits) {
  nlohmann::json out = nlohmann::json::array();
  for (const safety::LadderStep& step : pilotage.steps()) {
    TextLine seen;
    describe(seen, step.cause, step.seen, limits);
    out.push_back({{"t_s", core::seconds<double>(step.seen.now.time_since_epoch())},
                   {"from", safety::name(step.from)},
                   {"to", safety::name(step.to)},
                   {"cause", safety::name(step.cause)},
                   {"seen", std::string(seen.text())}});
  }
  return out;
}

}  // namespace

nlohmann::json flight_result(const FlyOptions& options, const Orders& orders, const Pilotage& pilotage,
                             const app::FlightController<double>& controller, std::uint32_t stalls,
                             const safety::Limits& limits) {
  const link::AuthorityView& authority = controller.link().authority();
  const est::Estimate<double>& estimate = controller.estimate();
  nlohmann::json out{{"channel", options.channel},
                     {"baud", options.baud},
                     {"mode", name(orders.flight->mode)},
                     {"obtained", pilotage.flew()},
                     {"released", pilotage.given_back()},
                     {"took_off", pilotage.took_off()},
                     {"landed", pilotage.landed()},
                     {"last_stage", safety::name(authority.stage)},
                     {"last_reason", safety::name(authority.reason)},
                     {"ladder", steps_json(pilotage, limits)},
                     {"checks_off", options.checks_off},
                     {"stalls", stalls},
                     {"position_m", {estimate.x.position_m, estimate.y.position_m, estimate.height_m}},
                     {"health", companion::to_json(controller.link().health())}};
  if (pilotage.swing()) {
    out["swinging"] = {{"t_s", core::seconds<double>(pilotage.swing()->now.time_since_epoch())},
                       {"height_rad", pilotage.swing()->swing_rad},
                       {"frequency_hz", pilotage.swing()->swing_hz}};
  }
  if (orders.excitation) {
    out["excitation"] = companion::to_json(controller.excitation(), *orders.excitation);
  }
  return out;
}

nlohmann::json room_result(const HeardStats& heard, std::uint32_t parameters_not_set) {
  return {{"goals", heard.goals},
          {"orders", heard.orders},
          {"orders_lost", heard.orders_lost},
          {"requests", heard.requests},
          {"requests_lost", heard.requests_lost},
          {"parameters_not_set", parameters_not_set}};
}

}  // namespace m100::companion
