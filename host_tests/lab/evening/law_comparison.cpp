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
#include "host_tests/lab/loop/vehicle_comparison.h"
#include "host_tests/lab/whole_file.h"
#include "host_tests/sim/world/base_plant.h"
#include "host_tests/sim/world/plant_file.h"

namespace m100::lab::evening {
namespace {

constexpr int kPairs = 5;
constexpr double kCourse_s = 40.0;
const std::array kParts{"horizontal", "vertical"};
// Names of the simulated pairs among the folder's numbers.
const std::string kAsFlown = "paired.", kAtEqualMargin = "paired_at_equal_margin.";

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

/// The simulated pairs that compare_laws() recorded under this name, for each of kParts.
PairedErrors recorded(const Folder& folder, const std::string& name) {
  const auto at = [&](const char* key) { return folder.numbers().at(name + key); };
  return {kPairs, at(".before_m"), at(".after_m"), {at(".after_m") - at(".before_m"), at(".low_m"), at(".high_m")}};
}

void record(Folder& folder, const std::string& name, const Flown& before, const Flown& after) {
  for (std::size_t i = 0; i < kParts.size(); ++i) {
    const PairedErrors pairs = compare_pairs(before[i], after[i]);
    const std::string part = name + kParts.at(i);
    folder.set_number(part + ".before_m", pairs.before_m);
    folder.set_number(part + ".after_m", pairs.after_m);
    folder.set_number(part + ".low_m", pairs.difference_m.low);
    folder.set_number(part + ".high_m", pairs.difference_m.high);
  }
}

void record_margins(Folder& folder, const std::string& name, const model::Vehicle& law, const model::Vehicle& truth) {
  const gains::TunedMargins margins = gains::margins_over(law, {{"the corrected model", truth}});
  folder.set_number("peak_sensitivity." + name, margins.stable ? margins.peak_sensitivity : 0.0);
  folder.set_number("delay_margin_s." + name, margins.stable ? margins.delay_margin_s : 0.0);
}

std::string margins_text(const Folder& folder, const char* name, const char* words) {
  const double peak = folder.numbers().at(std::string("peak_sensitivity.") + name);
  const double delay_s = folder.numbers().at(std::string("delay_margin_s.") + name);
  return std::string(words) + ", on the corrected model, " + gains::words(gains::kVirtualRcTiming) + ": " +
         (peak > 0.0 ? printed("peak sensitivity %.2f, delay margin %.0f ms", peak, 1e3 * delay_s) : "UNSTABLE");
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
    if (before.size() == 1) {
      first = first.empty() ? errors_of(folder, kBefore) : first;
      second = second.empty() ? errors_of(folder, kAfter) : second;
      out[key] = {1, before.front(), after.front(),
                  flight::compare_pair(flight::along(first, axes), flight::along(second, axes)).difference_m};
    } else if (!before.empty()) {
      out[key] = compare_pairs(before, after);
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
  const Flown after = fly(corrected.vehicle, plant, course);
  record(folder, kAsFlown, fly(first, plant, course), after);
  record(folder, kAtEqualMargin, fly(slowed, plant, course), after);
  record_margins(folder, "first", first, truth);
  record_margins(folder, "first_slowed_down", slowed, truth);
  record_margins(folder, "corrected", corrected.vehicle, truth);
  std::array<bool, kParts.size()> is_kept{};
  for (std::size_t i = 0; i < kParts.size(); ++i) {
    is_kept.at(i) = folder.settings().keep_worse || !recorded(folder, kAsFlown + kParts.at(i)).is_worse();
  }
  folder.set_number("kept.corrected", is_kept[0] ? 1.0 : 0.0);
  folder.set_number("kept.corrected_climb", is_kept[1] ? 1.0 : 0.0);
  if (!is_kept[1]) {
    folder.set_number("found.climb", 0.0);
  }
  const model::Vehicle climbs = is_kept[1] ? corrected.vehicle : first;
  corrected.vehicle = loop::with_channel(is_kept[0] ? corrected.vehicle : first, climbs, "climb");
  auto sources = is_kept[0] ? corrected.sources : first_file.sources;
  sources["axis.climb"] = (is_kept[1] ? corrected : first_file).sources["axis.climb"];
  companion::save_vehicle(folder.file("corrected.toml"), corrected.vehicle, sources);
}

std::vector<std::string> law_verdicts(const Folder& folder, const FlownErrors& flown) {
  std::vector<std::string> out;
  const std::map<std::string, double>& numbers = folder.numbers();
  for (const auto& [key, words] : {std::pair{"horizontal_m", "flights of the course, horizontal"},
                                   std::pair{"height_m", "flights of the course, height"}}) {
    if (flown.contains(key)) {
      out.push_back(std::string(words) + ", as flown: " + describe(flown.at(key)));
    }
  }
  out.push_back(paired_rule());
  if (!numbers.contains("kept.corrected")) {
    return out;
  }
  const auto add_simulated = [&](const std::string& name, const std::string& words) {
    for (const std::string part : kParts) {
      out.push_back("simulated on the corrected model, " + words + ", " + part + ": " +
                    describe(recorded(folder, name + part)));
    }
  };
  add_simulated(kAsFlown, "as flown");
  out.push_back(margins_text(folder, "first", "first law as flown"));
  out.push_back(margins_text(folder, "corrected", "corrected law"));
  if (numbers.contains(kAtEqualMargin + "horizontal.before_m") &&
      numbers.at("peak_sensitivity.first") != numbers.at("peak_sensitivity.first_slowed_down")) {
    out.push_back(margins_text(folder, "first_slowed_down",
                               "at equal margin: the first law as nobody flies it, slowed down to the corrected law's "
                               "peak sensitivity where possible"));
    add_simulated(kAtEqualMargin, "at equal margin");
  }
  const auto kept = [&](const char* key) { return numbers.at(std::string("kept.") + key) > 0.0; };
  out.emplace_back(kept("corrected") ? "kept: the corrected law"
                                     : "NOT KEPT: the corrected law is worse as flown, and that of vehicle.toml stays; "
                                       "--keep-worse takes the corrected one");
  if (!kept("corrected_climb")) {
    out.emplace_back(
        "NOT KEPT: the corrected climb is worse as flown, and that of vehicle.toml stays; --keep-worse "
        "takes the corrected one");
  }
  const bool is_worse = (flown.contains("horizontal_m") && flown.at("horizontal_m").is_worse()) ||
                        (flown.contains("height_m") && flown.at("height_m").is_worse());
  if (!flown.empty()) {
    const std::string file = is_worse && !folder.settings().keep_worse ? "vehicle" : "corrected";
    out.push_back("to fly on with: " + file + ".toml and " + file + ".gains");
  }
  return out;
}

}  // namespace m100::lab::evening
