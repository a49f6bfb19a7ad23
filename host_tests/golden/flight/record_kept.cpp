// SPDX-License-Identifier: BSD-3-Clause
// record_kept FOLDER: flies the kept flights on the simulated aircraft and writes their recordings.
#include <cstdio>
#include <filesystem>
#include <memory>

#include "host_tests/golden/flight/kept_flights.h"
#include "host_tests/golden/flight/recording_uart.h"
#include "host_tests/sim/ports/world.h"

namespace {

using namespace m100;

/// How a flight differs from a calm one: its plant and its events. `t_s` counts from the request for control.
struct ScriptedFlight {
  double seconds;
  void (*spoil)(sim::Plant& plant);
  /// @returns the operator's order before this tick: 0 none, 1 to fly, 2 to stop.
  std::uint32_t (*happen)(sim::World& world, int tick);
  int stalls_at = -1;  ///< the tick that comes 60 ms late
};

bool at(int tick, double t_s) { return tick == static_cast<int>(t_s * 100.0 + 0.5); }

std::uint32_t stops_at_9(sim::World&, int tick) { return at(tick, 9.0) ? 2 : 0; }

/// The poses drop out for 0.3 s and later for 3 s; then they come back, and the operator asks for control again.
std::uint32_t loses_poses(sim::World& world, int tick) {
  if (at(tick, 2.5) || at(tick, 4.0)) {
    world.pose_source().set_faults({.silent = true});
  } else if (at(tick, 2.8) || at(tick, 7.0)) {
    world.pose_source().set_faults({});
  }
  return at(tick, 7.5) ? 1U : 0U;
}

std::uint32_t standing_still(sim::World& world, int tick) {
  if (at(tick, 2.0)) {
    world.pose_source().set_faults({.jump_m = {0.2, 0.0, 0.0}});
  } else if (at(tick, 2.1)) {
    world.pose_source().set_faults({});
  } else if (at(tick, 4.0)) {
    const sim::SensorFault* const fault = sim::find_sensor_fault("standing");
    world.fault(*fault, fault->size);
  }
  return 0;
}

std::uint32_t tilt_rates_swapped(sim::World& world, int tick) {
  if (at(tick, 1.5)) {
    world.pose_source().set_faults({.not_finite = true});
  } else if (at(tick, 1.6)) {
    world.pose_source().set_faults({});
  } else if (at(tick, 3.6)) {
    const sim::SensorFault* const fault = sim::find_sensor_fault("tilt_rates_swapped");
    world.fault(*fault, fault->size);
  }
  return 0;
}

/// Bits flip on the lines from the autopilot and from the pose source; then the mode switch leaves F and comes back;
/// then the autopilot restarts.
std::uint32_t breaks_the_line(sim::World& world, int tick) {
  if (at(tick, 1.0)) {
    world.autopilot_line().b_to_a().set_faults({.flip_per_bit = 3e-4});
    world.pose_line().b_to_a().set_faults({.flip_per_bit = 3e-4});
  } else if (at(tick, 4.0)) {
    world.autopilot_line().b_to_a().set_faults({});
    world.pose_line().b_to_a().set_faults({});
    world.autopilot().set_mode(sim::N1Mode::kP);
  } else if (at(tick, 4.5)) {
    world.autopilot().set_mode(sim::N1Mode::kF);
  } else if (at(tick, 8.0)) {
    world.autopilot().happen(sim::N1EventKind::kRestart);
  }
  return at(tick, 5.0) ? 1U : 0U;
}

void calm(sim::Plant&) {}
void wind(sim::Plant& plant) {
  plant.air.linear_drag_per_s = 0.3;
  plant.air.wind_m_s = {4.0, -3.0, 0.0};
  plant.air.gust_m_s = 1.5;
  plant.air.turbulence_m_s = 0.75;
  plant.pose.jitter_s = 0.010;
  plant.pose.reported_age = sim::ReportedAge::kConstant;
  plant.pose.latency_s = 0.045;
}
/// After 6 s the wind needs more tilt than the program may command.
void storm(sim::Plant& plant) {
  plant.air.linear_drag_per_s = 0.3;
  plant.change = {.at_s = 6.0, .steps = {[](sim::Plant& changed) { changed.air.wind_m_s = {20.0, 8.0, 0.0}; }}};
}
/// A load of half a kilogram on a short cord, and a roll stick whose scale grows by half.
void load(sim::Plant& plant) {
  plant.payload = {.mass_kg = 0.5, .slung_length_m = 0.4, .picked_up_at_s = 4.0};
  plant.change = {.at_s = 6.0, .steps = {[](sim::Plant& changed) { changed.roll.scale_per_count *= 1.5; }}};
}
void delay(sim::Plant& plant) {
  for (model::StickAxis* const axis : {&plant.roll, &plant.pitch}) {
    axis->scale_per_count *= 1.4;
    axis->transport_delay_s += 0.1;
  }
}

/// In the order of kKeptFlights.
constexpr std::array kStories{ScriptedFlight{12.0, calm, stops_at_9},
                              ScriptedFlight{12.0, calm, stops_at_9},
                              ScriptedFlight{10.0, wind, stops_at_9, 400},
                              ScriptedFlight{10.0, calm, loses_poses},
                              ScriptedFlight{8.0, wind, standing_still},
                              ScriptedFlight{8.0, calm, tilt_rates_swapped},
                              ScriptedFlight{11.0, storm, [](sim::World&, int) { return 0U; }},
                              ScriptedFlight{10.0, load, stops_at_9},
                              ScriptedFlight{10.0, calm, breaks_the_line},
                              ScriptedFlight{12.0, delay, [](sim::World&, int) { return 0U; }},
                              ScriptedFlight{14.0, calm, [](sim::World&, int) { return 0U; }}};
static_assert(kStories.size() == golden::kKeptFlights.size());

/// The plant of a story. Poses come at 50 Hz only, to keep the recordings small.
sim::Plant plant_of(const ScriptedFlight& script) {
  sim::Plant plant = sim::measured_plant();
  plant.pose.rate_hz = 50.0;
  script.spoil(plant);
  return plant;
}

/// The operator: waits until all is ready, asks for control, then does what the story says.
class Operator {
 public:
  explicit Operator(const ScriptedFlight& script) : script_(script) {}

  bool goes_on() const { return since_ < static_cast<int>(script_.seconds * 100.0); }
  int since() const { return since_; }  ///< ticks since control was asked for; -1: not yet
  std::uint32_t order(sim::World& world, bool ready) {
    if (since_ < 0) {
      since_ = ready ? 0 : -1;
      return ready ? 1U : 0U;
    }
    return script_.happen(world, ++since_);
  }

 private:
  const ScriptedFlight& script_;
  int since_ = -1;
};

bool record(const golden::KeptFlight& kept, const ScriptedFlight& script, const std::filesystem::path& path) {
  std::ofstream file(path, std::ios::binary);
  sim::World world(plant_of(script), {.seed = 20171122, .autopilot = {.pilot_holds_position = true}});
  golden::RecordingUart autopilot(world.autopilot_uart());
  golden::RecordingUart pose(world.pose_uart());
  ref::Trajectory<double> course;
  mpc::GainTables<double> tables{mpc::generated::kX<double>, mpc::generated::kY<double>};
  if (golden::lay_kept_course(kept.course, course) != core::Status::kOk) {
    return false;
  }
  const auto controller = std::make_unique<app::FlightController<double>>(
      mpc::generated::kVehicle, tables, golden::config_of(kept), autopilot, pose, course, nullptr);
  const auto tick = std::make_unique<golden::RecordedTick>();
  Operator man(script);
  for (bool flew = false; man.goes_on();) {
    world.advance(core::kTickPeriod +
                  std::chrono::milliseconds(man.since() >= 0 && man.since() == script.stalls_at ? 50 : 0));
    const std::uint32_t order =
        man.order(world, controller->link().authority().stage == safety::AuthorityStage::kReady);
    tick->head = {.now_us = static_cast<std::uint32_t>(world.now().time_since_epoch().count()),
                  .autopilot_bytes = golden::take(world.autopilot_uart(), tick->autopilot),
                  .pose_bytes = golden::take(world.pose_uart(), tick->pose),
                  .engage = order};
    golden::write(file, *tick);
    autopilot.load(tick->from_autopilot());
    pose.load(tick->from_pose());
    if (order == 1) {
      controller->engage();
    } else if (order == 2) {
      controller->release();
    }
    static_cast<void>(controller->tick(world.now()));
    if (!flew && controller->grant().failsafe_state == safety::FailsafeState::kNominal) {
      flew = true;
      std::printf("%-10s control after %.2f s", kept.name, man.since() / 100.0);
    }
  }
  std::printf("; ends %s, %s\n", std::string(safety::name(controller->supervisor().descent().reason)).c_str(),
              std::string(safety::name(controller->link().authority().reason)).c_str());
  return controller->stats().ticks > 0 && file.good();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: record_kept FOLDER\n");
    return 2;
  }
  bool all = true;
  for (std::size_t i = 0; i < kStories.size(); ++i) {
    all = record(golden::kKeptFlights[i], kStories[i],
                 std::filesystem::path(argv[1]) / (std::string(golden::kKeptFlights[i].name) + ".recording")) &&
          all;
  }
  return all ? 0 : 1;
}
