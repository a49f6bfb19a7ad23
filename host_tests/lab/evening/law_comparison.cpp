// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/evening/law_comparison.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "firmware/companion/files/vehicle_file.h"
#include "host_tests/lab/evening/flight_result.h"
#include "host_tests/lab/evening/steps.h"
#include "host_tests/lab/experiments/flight.h"
#include "host_tests/lab/experiments/score.h"
#include "host_tests/lab/flight/tracking.h"
#include "host_tests/lab/loop/aligned_log.h"
#include "host_tests/lab/loop/ordered_margin.h"
#include "host_tests/lab/loop/results.h"
#include "host_tests/lab/loop/vehicle_comparison.h"
#include "host_tests/lab/whole_file.h"
#include "host_tests/sim/world/base_plant.h"
#include "host_tests/sim/world/plant_file.h"

namespace m100::lab::evening {
namespace {

constexpr int kPairs = 5;
constexpr double kCourse_s = 40.0;
const std::array kParts{"horizontal", "vertical"};

/// Horizontal and vertical error (root mean square) of each simulated flight of the course [m].
using Flown = std::array<std::vector<double>, kParts.size()>;

Flown fly(const model::Vehicle& law, const sim::Plant& plant, const std::string& course) {
  Flown out;
  experiments::FlightPlan plan;
  plan.plant = plant;
  plan.vehicle = companion::as_file(law);
  plan.course = course;
  plan.duration_s = kCourse_s;
  for (int i = 1; i <= kPairs; ++i) {
    plan.seed = static_cast<std::uint64_t>(i);
    const experiments::Cell cell = experiments::score(experiments::fly(plan).trace, kSettled_s, kCourse_s);
    out[0].push_back(std::hypot(cell.x_m, cell.y_m));
    out[1].push_back(cell.z_m);
  }
  return out;
}

void record_margins(Folder& folder, const std::string& name, const model::Vehicle& law, const model::Vehicle& truth) {
  const gains::TunedMargins margins = gains::margins_over(law, {{"the corrected model", truth}});
  folder.set_number("peak_sensitivity." + name, margins.stable ? margins.peak_sensitivity : 0.0);
  folder.set_number("delay_margin_s." + name, margins.stable ? margins.delay_margin_s : 0.0);
}

std::string margins_text(const Folder& folder, const char* name, const char* words) {
  const double peak = folder.numbers().at(std::string("peak_sensitivity.") + name);
  const double delay_s = folder.numbers().at(std::string("delay_margin_s.") + name);
  return std::string(words) + ", on the corrected model: " +
         (peak > 0.0 ? loop::two_numbers("peak sensitivity %.2f, delay margin %.0f ms", peak, 1e3 * delay_s)
                     : "UNSTABLE");
}

/// The errors of the flights NAME, NAME_2, ... that were flown.
std::vector<double> repeated(const Folder& folder, const std::string& quantity, const char* name) {
  std::vector<double> out;
  for (int flight = 1;; ++flight) {
    const auto found = folder.numbers().find(quantity + "." + name + (flight == 1 ? "" : "_" + std::to_string(flight)));
    if (found == folder.numbers().end()) {
      return out;
    }
    out.push_back(found->second);
  }
}

std::vector<flight::TrackingError> errors_of(const Folder& folder, const char* name) {
  return flight::tracking_errors(flight::read_series(folder.file(std::string(name) + ".ulg"), nullptr));
}

}  // namespace

FlownErrors compare_flights(const Folder& folder) {
  FlownErrors out;
  std::vector<flight::TrackingError> first, second;
  for (const auto& [key, axes] : std::map<std::string, std::array<double, 3>>{{"pose_m", {1.0, 1.0, 1.0}},
                                                                              {"horizontal_m", {1.0, 1.0, 0.0}},
                                                                              {"x_m", {1.0, 0.0, 0.0}},
                                                                              {"y_m", {0.0, 1.0, 0.0}},
                                                                              {"height_m", {0.0, 0.0, 1.0}}}) {
    std::vector<double> before = repeated(folder, key, kBefore);
    std::vector<double> after = repeated(folder, key, kAfter);
    before.resize(std::min(before.size(), after.size()));
    after.resize(before.size());
    if (before.size() > 1) {
      out[key] = loop::compare_pairs(before, after);
    } else if (before.size() == 1) {
      first = first.empty() ? errors_of(folder, kBefore) : first;
      second = second.empty() ? errors_of(folder, kAfter) : second;
      const flight::Interval found = flight::rms_difference(flight::along(first, axes), flight::along(second, axes));
      out[key] = {.flights = 1,
                  .before_m = before.front(),
                  .after_m = after.front(),
                  .difference_m = {found.value, found.low, found.high},
                  .verdict = flight::verdict_of(found)};
    }
  }
  return out;
}

void compare_laws(Folder& folder) {
  companion::VehicleFile first_file = companion::load_vehicle(folder.file("vehicle.toml"));
  const model::Vehicle& first = first_file.vehicle;
  companion::VehicleFile corrected = companion::load_vehicle(folder.file("corrected.toml"));
  const model::Vehicle truth = corrected.vehicle;
  const gains::TunedMargins kept = gains::margins_over(truth, {{"the corrected model", truth}});
  const loop::MarginOrder order{.peak_sensitivity = kept.peak_sensitivity, .delay_margin_s = kept.delay_margin_s};
  const model::Vehicle slowed = loop::at_ordered_margin(first, truth, order).vehicle;
  const std::string course = whole_file(folder.file("course.txt"));
  sim::Plant plant = sim::plant_of(truth);
  // The delay that a flight's log shows contains the transport of the link, which the simulated link adds itself.
  for (model::StickAxis* const axis : {&plant.roll, &plant.pitch}) {
    axis->transport_delay_s = std::max(0.0, axis->transport_delay_s - loop::kUplink_s - loop::kTelemetry_s);
  }
  const Flown before = fly(slowed, plant, course);
  const Flown after = fly(corrected.vehicle, plant, course);
  std::array<bool, kParts.size()> is_worse{};
  for (std::size_t i = 0; i < kParts.size(); ++i) {
    const loop::PairedErrors pairs = loop::compare_pairs(before[i], after[i]);
    const std::string name = std::string("paired.") + kParts.at(i);
    folder.set_number(name + ".before_m", pairs.before_m);
    folder.set_number(name + ".after_m", pairs.after_m);
    folder.set_number(name + ".low_m", pairs.difference_m.low);
    folder.set_number(name + ".high_m", pairs.difference_m.high);
    is_worse.at(i) = pairs.verdict == "worse";
  }
  record_margins(folder, "first", first, truth);
  record_margins(folder, "first_slowed_down", slowed, truth);
  record_margins(folder, "corrected", corrected.vehicle, truth);
  folder.set_number("kept.corrected", is_worse[0] ? 0.0 : 1.0);
  if (is_worse[1]) {
    folder.set_number("found.climb", 0.0);
  }
  folder.set_number("kept.corrected_climb", is_worse[1] ? 0.0 : 1.0);
  const model::Vehicle climbs = is_worse[1] ? slowed : corrected.vehicle;
  corrected.vehicle = loop::with_channel(is_worse[0] ? slowed : corrected.vehicle, climbs, "climb");
  auto sources = is_worse[0] ? first_file.sources : corrected.sources;
  sources["axis.climb"] = (is_worse[1] ? first_file : corrected).sources["axis.climb"];
  companion::save_vehicle(folder.file("corrected.toml"), corrected.vehicle, sources);
}

std::vector<std::string> law_verdicts(const Folder& folder, const FlownErrors& flown) {
  std::vector<std::string> out;
  const std::map<std::string, double>& numbers = folder.numbers();
  for (const auto& [key, words] : {std::pair{"horizontal_m", "flights of the course, horizontal"},
                                   std::pair{"height_m", "flights of the course, height"}}) {
    if (flown.contains(key)) {
      out.push_back(std::string(words) + ": " + loop::describe(flown.at(key)));
    }
  }
  if (!numbers.contains("kept.corrected")) {
    return out;
  }
  out.push_back(margins_text(folder, "first", "first law as flown"));
  out.push_back(margins_text(folder, "first_slowed_down",
                             "first law, slowed down to the corrected law's peak sensitivity where possible"));
  out.push_back(margins_text(folder, "corrected", "corrected law"));
  // Adding 0.0 turns -0.0 into 0.0, which is printed without a sign.
  const auto in_mm = [&](const std::string& key) { return std::round(1e4 * numbers.at(key)) / 10.0 + 0.0; };
  for (const char* const part : kParts) {
    const std::string name = std::string("paired.") + part;
    out.push_back(
        std::to_string(kPairs) + " simulated pairs on the corrected model, both laws at the same peak " +
        "sensitivity, " + part +
        loop::two_numbers(": %.1f mm before, %.1f mm after, ", in_mm(name + ".before_m"), in_mm(name + ".after_m")) +
        loop::two_numbers("difference [%+.1f, %+.1f] mm", in_mm(name + ".low_m"), in_mm(name + ".high_m")));
  }
  out.emplace_back(
      numbers.at("kept.corrected") > 0.0
          ? "kept: the corrected model"
          : "kept: the FIRST model, slowed down, because the corrected one flies worse at the same margin");
  if (const auto climb = numbers.find("kept.corrected_climb"); climb != numbers.end() && climb->second == 0.0) {
    out.emplace_back("for the climb the FIRST model is kept, because the corrected one flies worse in height");
  }
  return out;
}

}  // namespace m100::lab::evening
