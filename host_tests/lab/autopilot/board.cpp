// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/autopilot/board.h"

#include <algorithm>
#include <iostream>
#include <optional>

#include "host_tests/lab/autopilot/event_file.h"
#include "host_tests/sim/ports/emulated_board.h"
#include "host_tests/sim/ports/world.h"

namespace m100::lab::autopilot {

void run_with_board(const Options& options, const sim::Plant& plant, const sim::N1Config& config) {
  sim::World world(plant, {.seed = options.seed, .autopilot = config});
  std::optional<EventFile> events;
  if (!options.events.empty()) {
    events.emplace(options.events, EventFile::WriteMode::kAtOnce);
    world.autopilot().on_event([&](const sim::N1Event& event) { events->write(event); });
  }
  world.autopilot().happen(sim::N1EventKind::kLoss, options.loss);
  sim::EmulatedBoard board(options.board, "lockstep " + options.course);
  const int ticks = static_cast<int>((options.duration_s > 0.0 ? options.duration_s : 30.0) * 100.0);
  const core::Vector<double, 3> start = world.vehicle().state().position_w_m;
  double farthest_m = 0.0;
  for (int tick = 0; tick < ticks && !stop_requested(); ++tick) {
    world.pose_source().set_faults({.silent = !world.autopilot().pose_on()});
    world.advance(core::kTickPeriod);
    const hal::LockstepOrder order =
        tick == 600 ? hal::LockstepOrder::kEngage
                    : (tick == ticks - 300 ? hal::LockstepOrder::kRelease : hal::LockstepOrder::kNone);
    board.step(world.now(), order, world.autopilot_uart(), world.pose_uart());
    farthest_m = std::max(farthest_m, (world.vehicle().state().position_w_m - start).norm());
    if (events) {
      events->write_truth(world.now(), world.vehicle().state());
    }
  }
  std::cout << options.course << " flown by " << options.board << ": " << world.autopilot().record().virtual_rc_taken
            << " stick commands taken, at most " << farthest_m << " m from the start, exit status " << board.end()
            << std::endl;
  if (events) {
    events->summarise(world.now(), world.autopilot(), core::Duration{0});
  }
}

}  // namespace m100::lab::autopilot
