// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/property/identify/excited_flight.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "firmware/companion/files/excitation_file.h"
#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/excite/manoeuvre.h"
#include "host_tests/lab/experiments/flight.h"
#include "host_tests/sim/world/random.h"

namespace m100::host_tests {
namespace {

using lab::excite::InputDesign;
using lab::excite::Manoeuvre;

/// Of the log, beside the delay of the aircraft: from the tick that sets the sticks to the receiver, from the
/// autopilot's attitude to the tick that logs it, and what a stick that is sent every 20 ms adds; as measured over 52
/// axes of roll and pitch of 26 flights.
constexpr double kLine_s = 0.0207;

double draw(sim::Random& random, double low, double high) { return low + (high - low) * random.uniform(); }

/// The measured aircraft with another payload, other batteries and other propellers.
sim::Plant plant_of(std::uint64_t seed) {
  sim::Random random(seed, "excited plant");
  sim::Plant plant = sim::measured_plant();
  for (model::StickAxis* axis : {&plant.roll, &plant.pitch, &plant.climb, &plant.yaw_rate}) {
    axis->scale_per_count *= draw(random, 0.9, 1.1);
    axis->natural_frequency_rad_s *= draw(random, 0.8, 1.15);
    axis->time_constant_s *= draw(random, 0.8, 1.2);
    axis->damping_ratio *= draw(random, 0.9, 1.15);
    axis->dead_zone_counts *= draw(random, 0.6, 1.4);
    axis->stick_exponent *= axis->stick_exponent > 1.0 ? draw(random, 0.9, 1.1) : 1.0;
    axis->trim_counts += draw(random, -35.0, 35.0);
  }
  plant.roll.transport_delay_s = draw(random, 0.01, 0.07);
  plant.pitch.transport_delay_s = draw(random, 0.01, 0.07);
  plant.air.wind_m_s = {draw(random, -0.5, 0.5), draw(random, -0.5, 0.5), 0.0};
  plant.air.turbulence_m_s = draw(random, 0.0, 0.3);
  return plant;
}

model::Vehicle vehicle_of(const sim::Plant& plant, std::uint64_t seed) {
  sim::Random random(seed, "excited vehicle");
  model::Vehicle vehicle = mpc::generated::kVehicle;
  for (const auto& [believed, truly] :
       {std::pair{&vehicle.roll, &plant.roll}, std::pair{&vehicle.pitch, &plant.pitch},
        std::pair{&vehicle.climb, &plant.climb}, std::pair{&vehicle.yaw_rate, &plant.yaw_rate}}) {
    *believed = *truly;
    believed->scale_per_count *= draw(random, 0.95, 1.05);
    believed->natural_frequency_rad_s *= draw(random, 0.92, 1.08);
    believed->time_constant_s *= draw(random, 0.92, 1.08);
    believed->trim_counts += draw(random, -4.0, 4.0);
  }
  vehicle.roll.transport_delay_s += 0.01;
  vehicle.pitch.transport_delay_s += 0.01;
  return vehicle;
}

InputDesign design_of(const std::string& axis) {
  InputDesign design;
  design.axis = axis;
  design.amplitude_counts = 150.0;
  design.fence_m = 4.0;
  if (axis == "climb") {
    design.rate = true;
    design.air = 0.06;
    design.disturbance = 0.12;
    design.fence_m = 0.8;
  } else if (axis == "yaw_rate") {
    design.rate = true;
    design.air = 0.02;
    design.disturbance = 0.04;
    design.fence_m = 1.0;
  }
  return design;
}

const char* stick_of(const std::string& axis) {
  return axis == "climb" ? "throttle" : axis == "yaw_rate" ? "yaw" : axis == "pitch" ? "pitch" : "roll";
}

/// The movements of two axes, one after the other, as `m100-lab excite` writes them.
companion::ExcitationFile movements(const std::array<std::string, 2>& axes, const model::Vehicle& vehicle) {
  std::ostringstream out;
  std::array<Manoeuvre, 2> made;
  for (std::size_t k = 0; k < 2; ++k) {
    const InputDesign design = design_of(axes[k]);
    made[k] = lab::excite::design_manoeuvre(design, lab::excite::axis_of(vehicle, axes[k]));
    out << "# limits " << stick_of(axes[k]) << " distance " << design.fence_m << " braking " << design.brake_m_s2
        << " speed 6 tilt 0.5\n";
  }
  out << "t_s,piece,stick_" << stick_of(axes[0]) << ",stick_" << stick_of(axes[1]) << "\n";
  std::size_t row = 0;
  int before = 0;
  for (std::size_t k = 0; k < 2; ++k) {
    for (std::size_t i = 0; i < made[k].stick_counts.size(); ++i, ++row) {
      const int piece = made[k].piece[i];
      const double counts = made[k].stick_counts[i];
      out << 0.02 * static_cast<double>(row) << "," << (piece == 0 ? 0 : before + piece) << ","
          << (k == 0 ? counts : 0.0) << "," << (k == 1 ? counts : 0.0) << "\n";
    }
    before += *std::max_element(made[k].piece.begin(), made[k].piece.end());
  }
  return companion::parse_excitation(out.str(), "movements");
}

lab::logs::FlightLog read(const std::vector<std::uint8_t>& bytes, std::uint64_t seed) {
  namespace fs = std::filesystem;
  const fs::path file =
      fs::temp_directory_path() /
      ("excited_" + std::to_string(reinterpret_cast<std::uintptr_t>(&bytes)) + "_" + std::to_string(seed) + ".ulg");
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  lab::logs::FlightLog log = lab::logs::load(file.string(), "host_tests/lab/logs/maps/m100_log.toml");
  fs::remove(file);
  log.signals[static_cast<std::size_t>(lab::logs::Signal::kVelocityZ)].clear();  // as an evening's map of climb
  return log;
}

}  // namespace

ExcitedFlight fly_excited(std::uint64_t seed, bool rates) {
  ExcitedFlight out;
  out.plant = plant_of(seed);
  lab::experiments::FlightPlan plan;
  plan.plant = out.plant;
  plan.vehicle.vehicle = vehicle_of(out.plant, seed);
  const companion::ExcitationFile file =
      movements(rates ? std::array<std::string, 2>{"climb", "yaw_rate"} : std::array<std::string, 2>{"roll", "pitch"},
                plan.vehicle.vehicle);
  plan.excitation = file.plan();
  constexpr double kReturn_s = 6.0;
  plan.duration_s = 5.0 + file.length_s() + kReturn_s * static_cast<double>(file.pieces.size());
  plan.course = "step 0 0 0 0 " + std::to_string(plan.duration_s) + "\n";
  plan.seed = seed;
  plan.keep_log = true;
  const ctl::ExcitedStick first = rates ? ctl::ExcitedStick::kThrottle : ctl::ExcitedStick::kRoll;
  plan.operate = [&out, first](app::FlightController<double>& controller, double t_s) {
    const double begin_s = core::seconds<double>(controller.started().time_since_epoch());
    using State = ctl::Excitation<double>::State;
    const ctl::Excitation<double>& excitation = controller.excitation();
    if (excitation.state() == State::kMoving) {
      constexpr double kAfter_s = 1.0;
      lab::identify::Range& moved = out.moved_s[excitation.axis() == first ? 0 : 1];
      const double now_s = begin_s + t_s;
      moved = {moved.second > 0.0 ? moved.first : now_s, now_s + kAfter_s};
    }
    out.is_over = excitation.state() == State::kOver;
  };
  const lab::experiments::FlightResult flown = lab::experiments::fly(plan);
  out.log = read(flown.log, seed);
  return out;
}

std::vector<ExcitedAxis> axes_of(const ExcitedFlight& flight, bool rates) {
  const auto axis = [&flight](const char* name, std::size_t stick, const model::StickAxis& truly,
                              std::vector<std::string> declared) {
    ExcitedAxis out{name, flight.moved_s[stick], std::move(declared), {{"gain", truly.scale_per_count}}};
    if (truly.is_first_order()) {
      out.truth["gain"] *= -1.0;  // the yaw stick is positive to the right, a rate to the left
      out.truth["time_constant_s"] = truly.time_constant_s;
    } else {
      out.truth["natural_frequency_rad_s"] = truly.natural_frequency_rad_s;
      out.truth["damping_ratio"] = truly.damping_ratio;
    }
    if (out.name != "climb") {  // the delay of its height is that of the poses
      out.truth["delay_s"] = truly.transport_delay_s + kLine_s;
    }
    if (truly.stick_exponent > 1.0) {
      out.truth["exponent"] = truly.stick_exponent;
    } else {
      out.truth["width_counts"] = truly.dead_zone_counts;
    }
    out.truth["offset_counts"] = truly.trim_counts;
    return out;
  };
  const std::vector<std::string> effects{"second_order", "transport_delay", "dead_zone", "trim_offset"};
  if (!rates) {
    return {axis("roll", 0, flight.plant.roll, effects), axis("pitch", 1, flight.plant.pitch, effects)};
  }
  return {axis("climb", 0, flight.plant.climb, effects),
          axis("yaw_rate", 1, flight.plant.yaw_rate, {"first_order", "transport_delay", "stick_curve", "trim_offset"})};
}

}  // namespace m100::host_tests
