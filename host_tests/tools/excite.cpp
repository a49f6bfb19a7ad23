// SPDX-License-Identifier: BSD-3-Clause
// m100-lab excite: stick movements for identification, and how well they will separate the candidates.
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "firmware/app/vehicle_file.h"
#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/tools/excite/manoeuvre.h"
#include "host_tests/tools/input_error.h"
#include "host_tests/tools/subcommands.h"

namespace m100::tools {
namespace {

struct Options {
  excite::Wish wish;
  std::string vehicle, out, json;
  Options() { wish.fence_m = 0.0; }  // chosen by axis
};

// What air and autopilot leave with a resting stick; the climb's from the measured flight.
constexpr double kAirClimb_m_s = 0.06;
constexpr double kAirYaw_rad_s = 0.02;

void write_sticks(const excite::Manoeuvre& manoeuvre, const std::string& axis, const std::string& file) {
  std::ofstream out(file);
  out << "t_s,stick_" << axis << ",forecast_position_m,forecast_speed_m_s\n";
  for (std::size_t k = 0; k < manoeuvre.stick_counts.size(); ++k) {
    out << static_cast<double>(k) * manoeuvre.period_s << "," << manoeuvre.stick_counts[k] << ","
        << manoeuvre.position_m[k] << "," << manoeuvre.speed_m_s[k] << "\n";
  }
  if (!out) {
    throw InputError(file, 0, "--out", "cannot be written");
  }
}

bool enough(const excite::Forecast& one) {
  return one.sigma >= excite::kEnough_sigma && one.apart_sigma >= excite::kEnough_sigma;
}

void print(const excite::Manoeuvre& manoeuvre, const std::vector<excite::Forecast>& table, const excite::Wish& wish) {
  const char* const unit = wish.axis == "yaw_rate" ? "rad" : "m";
  std::printf("%s on %s: %.1f s, %.0f counts, at most %.1f %s from the start, %zu returns\n", wish.kind.c_str(),
              wish.axis.c_str(), static_cast<double>(manoeuvre.stick_counts.size()) * manoeuvre.period_s,
              manoeuvre.amplitude_counts, manoeuvre.farthest_m, unit, manoeuvre.returns);
  std::printf("abort: sticks neutral and fly back when |x| + v^2 / %.1f %s/s^2 > %.1f %s, v outwards\n",
              2 * wish.brake_m_s2, unit, wish.fence_m, unit);
  std::printf("%-16s %9s %8s  %-16s %9s %8s\n", "effect", "size", "sigma", "most alike", "likeness", "apart");
  for (const excite::Forecast& one : table) {
    std::printf("%-16s %9.4g %8.1f  %-16s %9.3f %8.1f%s\n", one.effect.c_str(), one.size, one.sigma,
                one.nearest.c_str(), one.likeness, one.apart_sigma, enough(one) ? "" : "  not enough");
  }
}

void run(const Options& options) {
  const model::Vehicle vehicle =
      options.vehicle.empty() ? mpc::generated::kVehicle : app::load_vehicle(options.vehicle).vehicle;
  excite::Wish wish = options.wish;
  wish.rate = wish.axis == "climb" || wish.axis == "yaw_rate";
  wish.air = wish.axis == "climb" ? kAirClimb_m_s : wish.axis == "yaw_rate" ? kAirYaw_rad_s : wish.air;
  wish.fence_m = wish.fence_m > 0.0 ? wish.fence_m : wish.axis == "climb" ? 2.0 : wish.rate ? 3.0 : 8.0;
  const model::AttitudeAxis axis = wish.axis == "roll"    ? vehicle.roll
                                   : wish.axis == "pitch" ? vehicle.pitch
                                   : wish.axis == "climb" ? excite::as_attitude(vehicle.climb)
                                                          : excite::as_attitude(vehicle.yaw_rate);
  excite::Manoeuvre manoeuvre;
  try {
    manoeuvre = excite::make(wish, axis);
  } catch (const std::invalid_argument& wrong) {
    throw InputError("excite", 0, "", wrong.what());
  }
  const std::vector<excite::Forecast> table = excite::forecast(manoeuvre, axis, wish);
  print(manoeuvre, table, wish);
  if (!options.out.empty()) {
    write_sticks(manoeuvre, wish.axis, options.out);
  }
  if (!options.json.empty()) {
    nlohmann::json json{{"axis", wish.axis},
                        {"amplitude_counts", manoeuvre.amplitude_counts},
                        {"farthest_m", manoeuvre.farthest_m},
                        {"fence_m", wish.fence_m},
                        {"abort_brake_m_s2", wish.brake_m_s2}};
    for (const excite::Forecast& one : table) {
      json["forecast"].push_back({{"effect", one.effect},
                                  {"size", one.size},
                                  {"sigma", one.sigma},
                                  {"most_alike", one.nearest},
                                  {"likeness", one.likeness},
                                  {"apart_sigma", one.apart_sigma},
                                  {"enough", enough(one)}});
    }
    std::ofstream out(options.json);
    out << json.dump(1) << "\n";
    if (!out) {
      throw InputError(options.json, 0, "--json", "cannot be written");
    }
  }
}

}  // namespace

void add_excite(CLI::App& lab) {
  CLI::App* app = lab.add_subcommand("excite", "make stick movements inside a fence, forecast what they will separate");
  auto options = std::make_shared<Options>();
  app->add_option("--axis", options->wish.axis, "roll, pitch, climb or yaw_rate")
      ->check(CLI::IsMember({"roll", "pitch", "climb", "yaw_rate"}));
  app->add_option("--kind", options->wish.kind, "doublet, 3211, chirp or mixed");
  app->add_option("--amplitude", options->wish.amplitude_counts, "stick counts");
  app->add_option("--duration", options->wish.duration_s, "seconds");
  app->add_option("--fence", options->wish.fence_m, "metres from the start (yaw_rate: rad)")
      ->check(CLI::PositiveNumber);
  app->add_option("--brake", options->wish.brake_m_s2, "deceleration that the abort counts on");
  app->add_option("--vehicle", options->vehicle, "vehicle file; without it the project's default");
  app->add_option("--out", options->out, "CSV of the sticks");
  app->add_option("--json", options->json, "the forecast as JSON");
  app->callback([options] { run(*options); });
}

}  // namespace m100::tools
