// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/tuning/tune_command.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <span>

#include "firmware/model/paper.h"
#include "host_tests/lab/experiments/far.h"
#include "host_tests/lab/experiments/flight.h"
#include "host_tests/lab/experiments/score.h"
#include "host_tests/lab/gains/tuning/design_search.h"
#include "host_tests/lab/gains/tuning/tune.h"
#include "host_tests/lab/on_all_cores.h"
#include "host_tests/sim/world/base_plant.h"

namespace m100::lab::gains {
namespace {

experiments::FlightPlan plan_of(const companion::VehicleFile& file, const sim::Plant& plant, const char* course,
                                double duration_s) {
  experiments::FlightPlan plan;
  plan.plant = plant;
  plan.vehicle = file;
  plan.course = course;
  plan.duration_s = duration_s;
  return plan;
}

/// The command motion [deg/s] in a simulated hover in calm air; infinite if the hover was not flown to its end, because
/// after a release the command is constant.
double hover_motion(const companion::VehicleFile& file, const sim::Plant& plant) {
  constexpr double kFrom_s = 10.0, kTo_s = 30.0;
  const experiments::FlightResult flight = experiments::fly(plan_of(file, plant, "step 0 0 0 0 40\n", kTo_s));
  return experiments::stayed(flight.trace) ? experiments::score(flight.trace, kFrom_s, kTo_s).input_variation_deg_s
                                           : std::numeric_limits<double>::infinity();
}

double horizontal(const experiments::Cell& cell) { return std::hypot(cell.x_m, cell.y_m); }

/// The plant in the air of the campaign's world wind_8: 8 m/s with gusts.
sim::Plant in_wind(sim::Plant plant) {
  plant.air.linear_drag_per_s = 0.3;
  plant.air.wind_m_s = {6.4, 4.8, 0.0};
  plant.air.gust_m_s = 2.4;
  plant.air.turbulence_m_s = 1.2;
  return plant;
}

constexpr double kFrom_s = 10.0, kHover_s = 35.0, kSquare_s = 30.0, kStep_s = 18.0;
constexpr std::array<std::uint64_t, 3> kStepSeeds{1, 2, 3};
constexpr std::size_t kFlights = 3 + kStepSeeds.size();
const experiments::FarTask kStep{
    .name = "step", .course = "step 0 0 0 0 10\nstep 6 0 0 0 20\n", .from_s = kFrom_s, .to_s = kStep_s};

/// The reference tasks on one aircraft: hover, hover in wind, square, and the step with three seeds. With one seed the
/// settling is that of one noise: 2.5 s or 3.3 s, because the last centimetres cross 2 cm or do not.
void add_tasks(const companion::VehicleFile& file, const sim::Plant& plant,
               std::vector<experiments::FlightPlan>& plans) {
  plans.push_back(plan_of(file, plant, "step 0 0 0 0 60\n", kHover_s));
  plans.push_back(plan_of(file, in_wind(plant), "step 0 0 0 0 60\n", kHover_s));
  plans.push_back(
      plan_of(file, plant, "step 0 0 0 0 10\nsquare 1 2.5 0\nsquare 1 2.5 0\nstep 0 0 0 0 20\n", kSquare_s));
  for (const std::uint64_t seed : kStepSeeds) {
    plans.push_back(plan_of(file, plant, kStep.course.c_str(), kStep_s));
    plans.back().seed = seed;
  }
}

/// @param flown the flights of add_tasks() for one aircraft
FlownScore score_of(std::span<const experiments::FlightResult, kFlights> flown) {
  const experiments::Cell calm = experiments::score(flown[0].trace, kFrom_s, kHover_s);
  FlownScore out{.hover_m = horizontal(calm),
                 .wind_m = horizontal(experiments::score(flown[1].trace, kFrom_s, kHover_s)),
                 .square_m = horizontal(experiments::score(flown[2].trace, kFrom_s, kSquare_s)),
                 .motion_deg_s = calm.input_variation_deg_s,
                 .stayed = std::all_of(flown.begin(), flown.end(), [](const experiments::FlightResult& one) {
                   return experiments::stayed(one.trace);
                 })};
  for (const experiments::FlightResult& step : flown.last<kStepSeeds.size()>()) {
    const experiments::FarScore far = experiments::far_score(step.trace, kStep);
    out.step_m_s += far.iae_m_s / 3.0;
    out.settled_s += far.settled_s / 3.0;
    out.tilt_deg = std::max(out.tilt_deg, step.largest_tilt_deg);
  }
  return out;
}

/// The mean of the errors over the open structures; the worst motion and tilt.
FlownScore fly_structures(const model::Vehicle& believed, const std::vector<sim::Plant>& plants) {
  const companion::VehicleFile file = companion::as_file(believed);
  std::vector<experiments::FlightPlan> plans;
  for (const sim::Plant& plant : plants) {
    add_tasks(file, plant, plans);
  }
  std::vector<experiments::FlightResult> flown(plans.size());
  on_all_cores(plans.size(), [&](std::size_t i) { flown[i] = experiments::fly(plans[i]); });
  FlownScore out{.stayed = true};
  const double share = 1.0 / static_cast<double>(plants.size());
  for (std::size_t k = 0; k < plants.size(); ++k) {
    const FlownScore one =
        score_of(std::span<const experiments::FlightResult, kFlights>(&flown[k * kFlights], kFlights));
    for (const auto member : {&FlownScore::hover_m, &FlownScore::wind_m, &FlownScore::square_m, &FlownScore::step_m_s,
                              &FlownScore::settled_s}) {
      out.*member += share * one.*member;
    }
    out.motion_deg_s = std::max(out.motion_deg_s, one.motion_deg_s);
    out.tilt_deg = std::max(out.tilt_deg, one.tilt_deg);
    out.stayed = out.stayed && one.stayed;
  }
  return out;
}

void print_margins(const DesignTrial& of) {
  std::printf("  nominal: %s, %s\n  worst corner: %s, %s\n  whole box: %s\n", of.nominal.peak_text().c_str(),
              of.nominal.delay_text().c_str(), of.corners.peak_text().c_str(), of.corners.delay_text().c_str(),
              of.box.peak_text().c_str());
}

void print_design(const char* mode, const ModeDesign& design, const FlownScore& before) {
  const DesignTrial& best = design.best;
  std::printf("%s: %s\n", mode,
              design.kept ? "the least flown error that keeps the limits" : "NO design keeps the limits; the nearest");
  print_margins(best);
  std::printf(
      "  horizontal error, before and now: hover %.4f %.4f m, wind %.4f %.4f m, square %.4f %.4f m, step of 6 m %.2f "
      "%.2f m s, settled in %.2f %.2f s; command %.0f %.0f deg/s, worst tilt %.0f %.0f deg\n",
      before.hover_m, best.flown.hover_m, before.wind_m, best.flown.wind_m, before.square_m, best.flown.square_m,
      before.step_m_s, best.flown.step_m_s, before.settled_s, best.flown.settled_s, before.motion_deg_s,
      best.flown.motion_deg_s, before.tilt_deg, best.flown.tilt_deg);
}

/// What the limits cost against the law that flies now, or that the new one is no worse than it.
void print_present(const DesignSearchResult& result) {
  const DesignTrial& now = result.present.best;
  std::printf("the law that flies now, on this model:\n");
  print_margins(now);
  if (result.present.kept) {
    std::printf("  it keeps the limits: the new design is no worse than it in hover, wind, square and step\n");
  } else {
    std::printf("  it exceeds the limits of mode field; to keep them costs %+.1f %% of its flown error\n",
                100.0 * (result.field.best.error / now.error - 1.0));
  }
}

void print_prices(const DesignSearchResult& result) {
  std::printf(
      "peak sensitivity over the whole box and the least flown error for it (1: the file before), of %zu flown "
      "trials; the worst of %s and %s, in the box 0 to 40 ms:\n",
      result.trials.size(), words(kVirtualRcTiming).c_str(), words(kMovementTiming).c_str());
  for (const double peak : {5.0, 4.0, 3.5, 3.0, 2.6, 2.2, 1.9, 1.6}) {
    if (const std::optional<DesignTrial> one = least_error(result.trials, {.box_peak = peak})) {
      std::printf("  %.1f  %.3f  (%.2f; corners %.2f, %.0f ms; hover %.4f, wind %.4f m, 6 m settled in %.2f s)\n", peak,
                  one->error, one->box.peak_sensitivity, one->corners.peak_sensitivity,
                  one->corners.delay_margin_s * 1e3, one->flown.hover_m, one->flown.wind_m, one->flown.settled_s);
    }
  }
  for (const auto& [name, member] : {std::pair{"peak in the corners", &MarginLimits::corner_peak},
                                     {"delay in the corners", &MarginLimits::corner_delay_s},
                                     {"peak over the whole box", &MarginLimits::box_peak},
                                     {"nominal peak", &MarginLimits::nominal_peak},
                                     {"nominal delay", &MarginLimits::nominal_delay_s}}) {
    MarginLimits left = kFieldLimits;
    left.*member = MarginLimits{}.*member;
    if (const auto one = least_error(result.trials, left)) {
      std::printf("  price of the limit on %s: %.1f %% of the flown error\n", name,
                  100.0 * std::max(0.0, result.field.best.error / one->error - 1.0));
    }
  }
}

/// Prints for each structure the worst peak that would be left if a manoeuvre had decided for this structure.
void print_manoeuvres(const model::Vehicle& vehicle, const std::vector<OpenStructure>& structures) {
  if (structures.size() < 2) {
    return;
  }
  for (const OpenStructure& one : structures) {
    const MarginBox alone({one});
    std::printf(
        "  if only \"%s\" were open (m100-lab excite --kind doublet with the gyro logged decides): worst corner: "
        "%s\n",
        one.name.c_str(), alone.worst(vehicle, MarginBox::Extent::kCorners).peak_text().c_str());
  }
}

void tune_input_weight(companion::VehicleFile& file, const std::vector<OpenStructure>& open, const sim::Plant& plant) {
  std::vector<Structure> structures(open.size());
  std::transform(open.begin(), open.end(), structures.begin(), [](const OpenStructure& one) {
    return Structure{one.name, one.vehicle};
  });
  const Tuned tuned = tune(file.vehicle, structures, [&](const model::Vehicle& believed) {
    return hover_motion(companion::as_file(believed), plant);
  });
  model::flown_weights(file.vehicle) = tuned.weights;
  std::printf(
      "input weight %.3g: %s as flown on %s: peak sensitivity %.2f, delay margin %.0f ms, command motion in hover "
      "%.0f deg/s\n",
      tuned.weights.input,
      tuned.keeps_all ? "the fastest loop that keeps the limits" : "no input weight keeps the limits; the nearest one,",
      words(kVirtualRcTiming).c_str(), tuned.kept.peak_sensitivity, tuned.kept.delay_margin_s * 1e3,
      tuned.motion_deg_s);
}

}  // namespace

void tune_vehicle(companion::VehicleFile& file, const model::Vehicle& present,
                  const std::vector<OpenStructure>& structures, const std::string& path) {
  const sim::Plant plant = sim::plant_of_options("", path);
  if (file.vehicle.roll.is_first_order() || file.vehicle.pitch.is_first_order()) {
    std::printf("an axis of first order: only the input weight is chosen\n");
    tune_input_weight(file, structures, plant);
    return;
  }
  std::vector<sim::Plant> plants;
  for (const OpenStructure& one : structures) {
    plants.push_back(plant);
    plants.back().roll = one.vehicle.roll;
    plants.back().pitch = one.vehicle.pitch;
    // No file knows the trim of the day; that of the paper's aircraft is as good as any.
    plants.back().roll.trim_counts += model::paper::kRollBalance_vrc - model::paper::kNeutral_vrc;
    plants.back().pitch.trim_counts += model::paper::kPitchBalance_vrc - model::paper::kNeutral_vrc;
  }
  const bool shows = isatty(STDERR_FILENO) != 0;
  int shown = 0;
  const auto progress = [&](double share, const std::string& what) {
    if (const int now = static_cast<int>(shows ? 100.0 * share : 10.0 * share); now > shown) {
      shown = now;
      std::fprintf(stderr, "%stune: %.0f %%, %s  %s", shows ? "\r" : "", 100.0 * share, what.c_str(),
                   shows ? "" : "\n");
    }
  };
  const DesignSearchResult result = search_designs(
      file.vehicle, present, MarginBox(structures),
      [&](const model::Vehicle& believed) { return fly_structures(believed, plants); }, progress);
  file.vehicle.design = result.field.best.design;
  file.vehicle.robust = result.robust.best.design;
  print_present(result);
  print_design("field", result.field, result.before);
  print_design("robust", result.robust, result.before);
  print_prices(result);
  print_manoeuvres(file.vehicle, structures);
}

}  // namespace m100::lab::gains
