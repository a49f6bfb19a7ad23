// SPDX-License-Identifier: BSD-3-Clause
// m100-lab excite: makes stick movements for identification, and forecasts how well they separate the candidates.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/text/suggestion.h"
#include "firmware/companion/files/vehicle_file.h"
#include "firmware/model/axis_effects.h"
#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/excite/forecast.h"
#include "host_tests/lab/excite/manoeuvre.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/option_words.h"
#include "host_tests/lab/printed.h"
#include "host_tests/lab/subcommands.h"

namespace m100::lab {
namespace {

struct ExciteOptions {
  excite::InputDesign design;
  std::string axes = "roll";
  std::string vehicle, out, json;
  ExciteOptions() { design.fence_m = 0.0; }  // chosen by axis
};

// Root mean square response to air and autopilot while the stick rests; that of climb is from the measured flight.
constexpr double kAirClimb_m_s = 0.06;
constexpr double kAirYaw_rad_s = 0.02;
// The largest disturbance that is assumed to act during a whole piece: twice the response to the air.
constexpr double kPushClimb_m_s = 0.12;
constexpr double kPushYaw_rad_s = 0.04;

/// The manoeuvre of one axis.
struct Made {
  excite::InputDesign design;
  model::StickAxis axis;
  excite::Manoeuvre manoeuvre;
  std::vector<excite::Forecast> table;
};

const char* stick_of(const std::string& axis) {
  return axis == "climb" ? "throttle" : axis == "yaw_rate" ? "yaw" : axis == "pitch" ? "pitch" : "roll";
}

/// The speed at which the flight is aborted: the forecast plus a margin for its error and for disturbances.
double speed_limit(const Made& one) {
  double longest_s = 0.0;
  double piece_s = 0.0;
  for (std::size_t k = 0; k < one.manoeuvre.piece.size(); ++k) {
    const bool goes_on = one.manoeuvre.piece[k] != 0 && k > 0 && one.manoeuvre.piece[k] == one.manoeuvre.piece[k - 1];
    piece_s = goes_on ? piece_s + one.manoeuvre.period_s : 0.0;
    longest_s = std::max(longest_s, piece_s);
  }
  return 1.5 * one.manoeuvre.fastest_m_s + 0.5 + (one.design.rate ? 0.0 : one.design.disturbance * longest_s);
}
double tilt_limit(const Made& one) {
  constexpr double kOthers_rad = 0.35;  // tilts that the law commands while another stick moves
  constexpr double kMax_rad = 0.55;     // promise R12: never above 35 degrees
  if (one.design.rate) {
    return kOthers_rad;
  }
  const std::vector<double> tilt = excite::response(one.manoeuvre, one.axis, one.design, "", 0.0);
  double largest = 0.0;
  for (const double value : tilt) {
    largest = std::max(largest, std::abs(value));
  }
  return std::min(kMax_rad, std::max(kOthers_rad, 1.5 * largest));
}

/// Writes the samples of all axes, one axis after the other, with time and piece numbers that continue.
void write_samples(const std::vector<Made>& all, std::ostream& out) {
  std::size_t row = 0;
  int pieces = 0;
  for (std::size_t moved = 0; moved < all.size(); ++moved) {
    const excite::Manoeuvre& manoeuvre = all[moved].manoeuvre;
    for (std::size_t k = 0; k < manoeuvre.stick_counts.size(); ++k, ++row) {
      const int piece = manoeuvre.piece[k];
      out << static_cast<double>(row) * manoeuvre.period_s << "," << (piece == 0 ? 0 : pieces + piece);
      for (std::size_t axis = 0; axis < all.size(); ++axis) {
        out << "," << (axis == moved ? manoeuvre.stick_counts[k] : 0.0);
      }
      out << "," << manoeuvre.position_m[k] << "," << manoeuvre.speed_m_s[k] << "\n";
    }
    pieces += *std::max_element(manoeuvre.piece.begin(), manoeuvre.piece.end());
  }
}

/// Writes the file for `m100 fly --excite`: the limits, then the samples of one axis after the other.
void write_sticks(const std::vector<Made>& all, const std::string& file) {
  std::ofstream out(file);
  out << "# Stick movements for m100 fly --excite, from m100-lab excite. Piece 0: the stick rests; in flight the law\n"
         "# returns to the start. Counts from the trim: right, forward, up, right are positive.\n";
  for (const Made& one : all) {
    out << "# limits " << stick_of(one.design.axis) << " distance " << one.design.fence_m << " braking "
        << one.design.brake_m_s2 << " speed " << speed_limit(one) << " tilt " << tilt_limit(one) << "\n";
  }
  out << "t_s,piece";
  for (const Made& one : all) {
    out << ",stick_" << stick_of(one.design.axis);
  }
  out << ",forecast_position_m,forecast_speed_m_s\n";
  write_samples(all, out);
  if (!out.flush()) {
    throw InputError(file, 0, "--out", "cannot be written");
  }
}

bool enough(const excite::Forecast& one) {
  return one.sigma >= excite::kMinSigma && one.apart_sigma >= excite::kMinSigma;
}

void print(const excite::Manoeuvre& manoeuvre, const std::vector<excite::Forecast>& table,
           const excite::InputDesign& design) {
  const char* const unit = design.axis == "yaw_rate" ? "rad" : "m";
  std::printf("%s on %s: %.1f s, %.0f counts, at most %.1f %s from the start, %zu returns\n", design.kind.c_str(),
              design.axis.c_str(), static_cast<double>(manoeuvre.stick_counts.size()) * manoeuvre.period_s,
              manoeuvre.amplitude_counts, manoeuvre.farthest_m, unit, manoeuvre.returns);
  if (manoeuvre.min_amplitude_counts < design.amplitude_counts || manoeuvre.in_parts + manoeuvre.left_out > 0) {
    std::printf(
        "adapted to the fence of %.1f %s, with a margin for an unforeseen push of %.2g %s: amplitudes of %.0f to %.0f "
        "counts instead of %.0f, %d of the movements in parts, %d left out\n",
        design.fence_m, unit, design.disturbance, design.rate ? (design.axis == "climb" ? "m/s" : "rad/s") : "m/s^2",
        manoeuvre.min_amplitude_counts, manoeuvre.amplitude_counts, design.amplitude_counts, manoeuvre.in_parts,
        manoeuvre.left_out);
  }
  std::printf("abort: sticks neutral and fly back if |x| + v^2 / %.1f %s/s^2 > %.1f %s (v: outward speed)\n",
              2 * design.brake_m_s2, unit, design.fence_m, unit);
  std::printf("%-16s %9s %8s  %-16s %9s %8s\n", "effect", "size", "sigma", "most alike", "likeness", "apart");
  for (const excite::Forecast& one : table) {
    std::printf("%-16s %9.4g %8.1f  %-16s %9.3f %8.1f%s\n", one.effect.c_str(), one.size, one.sigma,
                one.nearest.c_str(), one.cosine, one.apart_sigma, enough(one) ? "" : "  not enough");
  }
}

/// The design for one axis, with the air noise, the disturbance and the default fence of this axis.
excite::InputDesign wish_for(const std::string& axis, excite::InputDesign design) {
  design.axis = axis;
  double room_m = 8.0;
  if (axis == "climb") {
    design.rate = true;
    design.air = kAirClimb_m_s;
    design.disturbance = kPushClimb_m_s;
    room_m = 2.0;
  } else if (axis == "yaw_rate") {
    design.rate = true;
    design.air = kAirYaw_rad_s;
    design.disturbance = kPushYaw_rad_s;
    room_m = 3.0;
  }
  design.fence_m = design.fence_m > 0.0 ? design.fence_m : room_m;
  return design;
}

Made design_manoeuvre(const std::string& axis, const ExciteOptions& options, const model::Vehicle& vehicle) {
  Made out{
      .design = wish_for(axis, options.design), .axis = excite::axis_of(vehicle, axis), .manoeuvre = {}, .table = {}};
  if (out.axis.dead_zone_counts > 0.0 && out.design.amplitude_counts <= out.axis.dead_zone_counts) {
    throw InputError("--amplitude", 0, "",
                     printed("%g counts are inside the dead zone of %s, %g counts: the aircraft would not move",
                             out.design.amplitude_counts, axis.c_str(), out.axis.dead_zone_counts));
  }
  try {
    out.manoeuvre = excite::design_manoeuvre(out.design, out.axis);
  } catch (const std::invalid_argument& wrong) {
    throw InputError("excite", 0, "", wrong.what());
  }
  out.table = excite::forecast(out.manoeuvre, out.axis, out.design);
  return out;
}

Json to_json(const Made& one) {
  Json json{{"axis", one.design.axis},
            {"amplitude_counts", one.manoeuvre.amplitude_counts},
            {"least_amplitude_counts", one.manoeuvre.min_amplitude_counts},
            {"in_parts", one.manoeuvre.in_parts},
            {"left_out", one.manoeuvre.left_out},
            {"farthest_m", one.manoeuvre.farthest_m},
            {"fence_m", one.design.fence_m},
            {"abort_brake_m_s2", one.design.brake_m_s2}};
  for (const excite::Forecast& effect : one.table) {
    json["forecast"].push_back({{"effect", effect.effect},
                                {"size", effect.size},
                                {"sigma", effect.sigma},
                                {"most_alike", effect.nearest},
                                {"likeness", effect.cosine},
                                {"apart_sigma", effect.apart_sigma},
                                {"enough", enough(effect)}});
  }
  return json;
}

std::vector<std::string> axes_of(const std::string& words) {
  constexpr std::array<std::string_view, 4> kAxes{"roll", "pitch", "climb", "yaw_rate"};
  std::vector<std::string> axes = list_of("--axis", words);
  for (const std::string& axis : axes) {
    const bool is_known = std::find(kAxes.begin(), kAxes.end(), axis) != kAxes.end();
    if (!is_known || std::count(axes.begin(), axes.end(), axis) != 1) {
      throw InputError(
          "--axis", 0, axis,
          "must be roll, pitch, climb or yaw_rate, each once" + (is_known ? "" : companion::did_you_mean(axis, kAxes)));
    }
  }
  return axes;
}

void run(const ExciteOptions& options) {
  companion::FileUse()
      .reads("--vehicle", options.vehicle)
      .writes("--out", options.out)
      .writes("--json", options.json)
      .check();
  const model::Vehicle vehicle =
      options.vehicle.empty() ? mpc::generated::kVehicle : companion::load_vehicle(options.vehicle).vehicle;
  std::vector<Made> all;
  for (const std::string& axis : axes_of(options.axes)) {
    all.push_back(design_manoeuvre(axis, options, vehicle));
  }
  for (const Made& one : all) {
    print(one.manoeuvre, one.table, one.design);
  }
  if (!options.out.empty()) {
    write_sticks(all, options.out);
  }
  if (!options.json.empty()) {
    Json json = to_json(all.front());  // the first axis also at the top level, as for a single axis
    for (const Made& one : all) {
      json["axes"][one.design.axis] = to_json(one);
    }
    write_json(options.json, json.sorted());
  }
  // Not counted: a trim, which shows while the stick rests, and effects of the other stick, whose movement is assumed.
  const auto shows = [](const excite::Forecast& one) {
    return one.effect != "trim_offset" && !model::axis_effect(one.effect)->needs_other_stick && enough(one);
  };
  const auto any_enough = [&](const Made& one) { return std::any_of(one.table.begin(), one.table.end(), shows); };
  if (std::none_of(all.begin(), all.end(), any_enough)) {
    std::fprintf(stderr,
                 "m100-lab: excite: no effect but a trim would be found: take a larger --amplitude or --duration\n");
    throw companion::AnswerIsNo();
  }
}

}  // namespace

void add_excite(companion::CommandLine& lab) {
  const auto [app, options] = lab.add_subcommand<ExciteOptions>(
      "excite", "make stick movements inside a fence, and forecast which effects they separate", run);
  app.add_option("--axis", options->axes, "roll, pitch, climb or yaw_rate; several with commas, flown in that order");
  app.add_option("--kind", options->design.kind,
                 "doublet, 3211, chirp, mixed, or sweep: slow ramps through neutral, which show the dead zone");
  app.add_option("--amplitude", options->design.amplitude_counts, "amplitude in stick counts");
  app.add_option("--duration", options->design.duration_s, "seconds for each axis");
  app.add_option("--fence", options->design.fence_m, "largest distance from the start in metres (yaw_rate: rad)")
      .from_to(0.1, 1000.0);
  app.add_option("--brake", options->design.brake_m_s2,
                 "deceleration that the abort assumes [m/s^2; yaw_rate: rad/s^2]");
  app.add_option("--vehicle", options->vehicle, "vehicle file; default: the project's");
  app.add_option("--out", options->out, "CSV of the sticks, for m100 fly --excite");
  app.add_option("--json", options->json, "the forecast as JSON");
}

}  // namespace m100::lab
