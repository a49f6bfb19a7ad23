// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/preflight/model_findings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "firmware/app/config.h"
#include "firmware/model/tilt_limit.h"

namespace m100::companion {
namespace {

constexpr std::array kNames{std::string_view("sections"),   std::string_view("table_tilt"),
                            std::string_view("tilt_limit"), std::string_view("climb_limit"),
                            std::string_view("yaw_limit"),  std::string_view("table_delay"),
                            std::string_view("trim")};
constexpr std::array kChecksInFlight{est::ConsistencyCheck::kForce,   est::ConsistencyCheck::kClimb,
                                     est::ConsistencyCheck::kHeading, est::ConsistencyCheck::kMotion,
                                     est::ConsistencyCheck::kRates,   est::ConsistencyCheck::kAnswer};
constexpr double kMaxTrim_counts = 200.0;

bool same(double a, double b) { return std::abs(a - b) <= 1e-9 * (1.0 + std::abs(a)); }

}  // namespace

std::vector<ConsistencyFinding> findings(const FlightModel& model) {
  const VehicleFile& file = model.file();
  const model::Vehicle& vehicle = file.vehicle;
  const model::Vehicle predicted = model::controller_model(vehicle);
  const mpc::GainTables<double>& tables = model.tables();
  const safety::Envelope& envelope = app::kDefaultFlight.envelope;
  const auto& [sections, table_tilt, tilt_limit, climb_limit, yaw_limit, table_delay, trim] = kNames;
  std::vector<ConsistencyFinding> out;
  for (const char* section : {"axis.roll", "axis.pitch", "axis.yaw_rate", "axis.climb"}) {
    out.push_back({sections, file.sections.contains(section), std::string("[") + section + "] is in the vehicle file"});
  }
  const double limit = vehicle.translation.tilt_limit_rad;
  const double slope = model::slope_at_limit(limit);
  out.push_back({table_tilt, same(tables.x.input_max_slope, slope) && same(tables.y.input_max_slope, slope),
                 "the tables' input limit is the tangent of the vehicle's tilt limit"});
  out.push_back({tilt_limit, limit <= envelope.tilt_rad + 1e-12, "the tilt limit is inside the supervisor's envelope"});
  out.push_back({climb_limit, vehicle.altitude.climb_limit_m_s <= envelope.climb_m_s,
                 "the climb limit is inside the supervisor's envelope"});
  out.push_back({yaw_limit, vehicle.yaw.rate_limit_rad_s <= envelope.yaw_rate_rad_s + 1e-12,
                 "the yaw rate limit is inside the supervisor's envelope"});
  out.push_back({table_delay,
                 same(tables.x.delay.delay_s, predicted.pitch.transport_delay_s) &&
                     same(tables.y.delay.delay_s, predicted.roll.transport_delay_s),
                 "the tables predict through the vehicle's transport delays, or those of its design"});
  out.push_back(
      {trim,
       std::abs(vehicle.roll.trim_counts) < kMaxTrim_counts && std::abs(vehicle.pitch.trim_counts) < kMaxTrim_counts,
       "the trims leave the sticks room on both sides"});
  return out;
}

std::vector<std::string> names_for_override() {
  std::vector<std::string> out;
  std::transform(std::begin(kChecksInFlight), std::end(kChecksInFlight), std::back_inserter(out),
                 [](est::ConsistencyCheck check) { return std::string(est::name(check)); });
  out.insert(out.end(), kNames.begin(), kNames.end());
  return out;
}

FlightModel sound_model(const FlyOptions& options, Mode mode) {
  FlightModel model(options.vehicle, options.gains, mode);
  for (const ConsistencyFinding& finding : findings(model)) {
    const bool is_off = std::find(options.disabled_checks.begin(), options.disabled_checks.end(), finding.name) !=
                        options.disabled_checks.end();
    if (!finding.holds && !is_off) {
      const std::string name(finding.name);
      throw UsageError(options.vehicle + ": m100 check finds this wrong: " + finding.what + "; --override " + name +
                       " flies nevertheless");
    }
  }
  return model;
}

}  // namespace m100::companion
