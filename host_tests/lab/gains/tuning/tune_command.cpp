// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/tuning/tune_command.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <mutex>

#include "firmware/companion/files/mode.h"
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

/// The identified aircraft.
sim::Plant plant_of(const model::Vehicle& vehicle, const std::string& path) {
  sim::Plant plant = sim::plant_of_options("", path);
  plant.roll = vehicle.roll;
  plant.pitch = vehicle.pitch;
  // No file knows the trim of the day; that of the paper's aircraft is as good as any.
  plant.roll.trim_counts += model::paper::kRollBalance_vrc - model::paper::kNeutral_vrc;
  plant.pitch.trim_counts += model::paper::kPitchBalance_vrc - model::paper::kNeutral_vrc;
  return plant;
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

constexpr double kFrom_s = 10.0, kSquare_s = 35.0, kSteps_s = 55.0, kStep_s = 8.0;
constexpr int kSteps = 3;
constexpr const char* kHover = "step 0 0 0 0 60\n";
constexpr const char* kCalm =
    "step 0 0 0 0 35\nsquare 1 2.5 0\nsquare 1 2.5 0\nstep 6 0 0 0 8\nstep 0 0 0 0 8\nstep 6 0 0 0 8\n";

/// The reference tasks of the identified aircraft in two flights: hover, square and three steps in calm air; hover in
/// wind. One step would have the settling of one noise: 2.5 s or 3.3 s, because the last centimetres cross 2 cm or do
/// not.
FlownScore fly_tasks(const model::Vehicle& believed, const sim::Plant& plant) {
  const companion::VehicleFile file = companion::as_file(believed);
  const std::array plans{plan_of(file, plant, kCalm, kSteps_s + kSteps * kStep_s),
                         plan_of(file, in_wind(plant), kHover, kSquare_s)};
  std::array<experiments::FlightResult, plans.size()> flown;
  on_all_cores(plans.size(), [&](std::size_t i) { flown[i] = experiments::fly(plans[i]); });
  const experiments::Trace &calm = flown[0].trace, &wind = flown[1].trace;
  const experiments::Cell hover = experiments::score(calm, kFrom_s, kSquare_s);
  FlownScore out{.hover_m = horizontal(hover),
                 .wind_m = horizontal(experiments::score(wind, kFrom_s, kSquare_s)),
                 .square_m = horizontal(experiments::score(calm, kSquare_s, kSteps_s)),
                 .motion_deg_s = hover.input_variation_deg_s,
                 .tilt_deg = flown[0].largest_tilt_deg,
                 .stayed = experiments::stayed(calm) && experiments::stayed(wind)};
  for (int k = 0; k < kSteps; ++k) {
    const double from_s = kSteps_s + k * kStep_s;
    const experiments::FarScore far =
        experiments::far_score(calm, {.name = {}, .course = {}, .from_s = from_s, .to_s = from_s + kStep_s});
    out.step_m_s += far.iae_m_s / kSteps;
    out.settled_s += far.settled_s / kSteps;
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

/// The peak sensitivity with gain (1), frequency (2) or delay (3) alone at an end of its range; 0: as identified.
double peak_at_end(const FlownController& controller, const OpenStructure& of, Axis axis, std::size_t which,
                   bool high) {
  const AxisBox& box = of.box[axis == Axis::kX ? 0 : 1];
  const auto end = [&](std::size_t one, const Range& range, double identified) {
    const double number = high ? range.high : range.low;
    return which == one ? number : identified;
  };
  model::Vehicle truth = of.vehicle;
  model::StickAxis& changed = axis == Axis::kX ? truth.pitch : truth.roll;
  const double gain = end(1, box.gain, 1.0), frequency = end(2, box.frequency, 1.0);
  changed.natural_frequency_rad_s *= frequency;
  changed.time_constant_s /= frequency;
  changed.transport_delay_s = end(3, box.delay_s, changed.transport_delay_s);
  const FlownLoop loop(controller, truth, axis, controller.timing);
  const Margins margins = margins_from([&](double w) { return gain * loop.response(w); }, loop.period_s(), 400);
  return margins.stable ? margins.peak_sensitivity : std::numeric_limits<double>::infinity();
}

/// The largest peaks of both axes, channels and ends, in the order of peak_at_end().
std::array<double, 4> peaks_alone(const model::Vehicle& believed, const OpenStructure& of) {
  std::array<double, 4> out{};
  for (const Axis axis : {Axis::kX, Axis::kY}) {
    for (const LoopTiming& timing : {kVirtualRcTiming, kMovementTiming}) {
      const FlownController controller(believed, axis, timing);
      for (std::size_t k = 0; k < out.size(); ++k) {
        out[k] =
            std::max({out[k], peak_at_end(controller, of, axis, k, false), peak_at_end(controller, of, axis, k, true)});
      }
    }
  }
  return out;
}

}  // namespace

void tune_vehicle(companion::VehicleFile& file, const model::Vehicle& present,
                  const std::vector<OpenStructure>& structures, const std::string& path) {
  if (file.vehicle.roll.is_first_order() || file.vehicle.pitch.is_first_order()) {
    std::printf("an axis of first order: only the input weight is chosen\n");
    tune_input_weight(file, structures, sim::plant_of_options("", path));
    return;
  }
  const sim::Plant plant = plant_of(file.vehicle, path);
  const bool shows = isatty(STDERR_FILENO) != 0;
  int shown = 0;
  std::mutex showing;
  const auto progress = [&](double share, const std::string& what) {
    const std::lock_guard<std::mutex> one_at_a_time(showing);
    if (const int now = static_cast<int>(shows ? 100.0 * share : 5.0 * share); now > shown) {
      shown = now;
      std::fprintf(stderr, "%stune: %.0f %%, %s  %s", shows ? "\r" : "", 100.0 * share, what.c_str(),
                   shows ? "" : "\n");
    }
  };
  const DesignSearchResult result = search_designs(
      file.vehicle, present, MarginBox(structures),
      [&](const model::Vehicle& believed) { return fly_tasks(believed, plant); }, progress);
  file.vehicle.design = result.field.best.design;
  file.vehicle.robust = result.robust.best.design;
  print_present(result);
  print_design("field", result.field, result.before);
  print_design("robust", result.robust, result.before);
  print_prices(result);
  print_manoeuvres(file.vehicle, structures);
}

void print_what_limits(const model::Vehicle& believed, const OpenStructure& own, const companion::VehicleFile& file,
                       const std::string& path) {
  const std::array<double, 4> peak = peaks_alone(believed, own);
  const auto most = static_cast<std::size_t>(std::max_element(peak.begin() + 1, peak.end()) - peak.begin());
  std::printf(
      "%s limits this aircraft most: peak sensitivity %.2f as identified, %.2f with gain, %.2f with frequency, %.2f "
      "with "
      "delay alone at the worse end of its range",
      std::array{"nothing", "gain", "frequency", "delay"}[most], peak[0], peak[1], peak[2], peak[3]);
  if (companion::has_mode(file, companion::Mode::kRobust)) {
    const auto hover_m = [&](companion::Mode mode) {
      const companion::VehicleFile flown = companion::as_file(companion::in_mode(file.vehicle, mode));
      const auto flight = experiments::fly(plan_of(flown, plant_of(own.vehicle, path), kHover, kSquare_s));
      return horizontal(experiments::score(flight.trace, kFrom_s, kSquare_s));
    };
    const double field_m = hover_m(companion::Mode::kField), robust_m = hover_m(companion::Mode::kRobust);
    std::printf("; in hover in calm air mode robust errs by %.1f mm, %.1f times as much as mode field", 1e3 * robust_m,
                robust_m / field_m);
  }
  std::printf("\n");
}

}  // namespace m100::lab::gains
