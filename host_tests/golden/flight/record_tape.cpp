// SPDX-License-Identifier: BSD-3-Clause
// record_tape TAPE SECONDS: flies the board's course on the simulated aircraft and writes what the program received.
#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <vector>

#include "host_tests/golden/flight/tape.h"
#include "host_tests/sim/ports/world.h"

namespace {

using m100::golden::TapeTick;

std::uint16_t take(m100::hal::Uart& from, std::span<std::byte> into) {
  std::size_t filled = 0;
  for (std::size_t count = 1; count > 0 && filled < into.size(); filled += count) {
    count = from.read(into.subspan(filled)).value_or(0);
  }
  return static_cast<std::uint16_t>(filled);
}

void write(std::ofstream& file, std::span<const std::byte> bytes) {
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

/// Records what the program is given, and passes on what it sends.
class RecordingUart final : public m100::hal::Uart {
 public:
  RecordingUart(m100::hal::Uart& line) : line_(line) {}
  void load(std::span<const std::byte> bytes) { waiting_.assign(bytes.begin(), bytes.end()); }
  m100::core::Expected<std::size_t> read(std::span<std::byte> destination) override {
    const std::size_t count = std::min(destination.size(), waiting_.size());
    std::copy_n(waiting_.begin(), count, destination.begin());
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
    return count;
  }
  m100::core::Expected<std::size_t> write(std::span<const std::byte> source) override { return line_.write(source); }

 private:
  m100::hal::Uart& line_;
  std::vector<std::byte> waiting_;
};

}  // namespace

int main(int argc, char** argv) {
  using namespace m100;
  if (argc != 3) {
    std::fprintf(stderr, "usage: record_tape TAPE SECONDS\n");
    return 2;
  }
  std::ofstream file(argv[1], std::ios::binary);
  sim::World world(sim::measured_plant(), {.seed = 20171122});
  RecordingUart autopilot(world.autopilot_uart());
  RecordingUart pose(world.pose_uart());
  ref::Trajectory<double> course;
  mpc::GainTables<double> tables{mpc::generated::kX<double>, mpc::generated::kY<double>};
  app::FlightConfig config = app::kDefaultFlight;
  config.link.app_id = 1;
  if (app::lay_board_course(golden::kTapeCourse, course) != core::Status::kOk) {
    return 1;
  }
  const auto controller = std::make_unique<app::FlightController<double>>(mpc::generated::kVehicle, tables, config,
                                                                          autopilot, pose, course, nullptr);
  const auto tick = std::make_unique<TapeTick>();
  bool ordered = false;
  bool flew = false;
  for (int left = std::atoi(argv[2]) * 100; left > 0; --left) {
    world.advance(core::kTickPeriod);
    const bool ready = controller->link().authority().stage == safety::Stage::kReady;
    tick->head = {.now_us = static_cast<std::uint32_t>(world.now().time_since_epoch().count()),
                  .autopilot_bytes = take(world.autopilot_uart(), tick->autopilot),
                  .pose_bytes = take(world.pose_uart(), tick->pose),
                  .engage = ready && !ordered ? 1U : 0U};
    ordered = ordered || ready;
    write(file, std::as_bytes(std::span(&tick->head, 1)));
    write(file, tick->from_autopilot());
    write(file, tick->from_pose());
    autopilot.load(tick->from_autopilot());
    pose.load(tick->from_pose());
    if (tick->head.engage == 1) {
      controller->engage();
    }
    static_cast<void>(controller->tick(world.now()));
    flew = flew || controller->grant().rung == safety::Rung::kNominal;
  }
  std::printf("%s: %s\n", argv[1], flew ? "control obtained, course flown" : "control never obtained");
  return flew && file.good() ? 0 : 1;
}
