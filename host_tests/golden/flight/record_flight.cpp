// SPDX-License-Identifier: BSD-3-Clause
// record_flight RECORDING SECONDS: flies the board's course on the simulated aircraft and records the input of the
// program.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>

#include "host_tests/golden/flight/recording_uart.h"
#include "host_tests/sim/ports/world.h"

int main(int argc, char** argv) {
  using namespace m100;
  if (argc != 3) {
    std::fprintf(stderr, "usage: record_flight RECORDING SECONDS\n");
    return 2;
  }
  std::ofstream file(argv[1], std::ios::binary);
  sim::World world(sim::measured_plant(), {.seed = 20171122});
  golden::RecordingUart autopilot(world.autopilot_uart());
  golden::RecordingUart pose(world.pose_uart());
  ref::Trajectory<double> course;
  mpc::GainTables<double> tables{mpc::generated::kX<double>, mpc::generated::kY<double>};
  app::FlightConfig config = app::kDefaultFlight;
  config.link.app_id = 1;
  if (app::append_board_course(golden::kRecordingCourse, course) != core::Status::kOk) {
    return 1;
  }
  const auto controller = std::make_unique<app::FlightController<double>>(mpc::generated::kVehicle, tables, config,
                                                                          autopilot, pose, course, nullptr);
  const auto tick = std::make_unique<golden::RecordedTick>();
  bool ordered = false;
  bool flew = false;
  for (int left = std::atoi(argv[2]) * 100; left > 0; --left) {
    world.advance(core::kTickPeriod);
    const bool ready = controller->link().authority().stage == safety::AuthorityStage::kReady;
    tick->head = {.now_us = static_cast<std::uint32_t>(world.now().time_since_epoch().count()),
                  .autopilot_bytes = golden::take(world.autopilot_uart(), tick->autopilot),
                  .pose_bytes = golden::take(world.pose_uart(), tick->pose),
                  .engage = ready && !ordered ? 1U : 0U};
    ordered = ordered || ready;
    golden::write(file, *tick);
    autopilot.load(tick->from_autopilot());
    pose.load(tick->from_pose());
    if (tick->head.engage == 1) {
      controller->engage();
    }
    static_cast<void>(controller->tick(world.now()));
    flew = flew || controller->grant().failsafe_state == safety::FailsafeState::kNominal;
  }
  std::printf("%s: %s\n", argv[1], flew ? "control obtained, course flown" : "control never obtained");
  return flew && file.good() ? 0 : 1;
}
