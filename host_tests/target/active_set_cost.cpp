// SPDX-License-Identifier: BSD-3-Clause
// Measures on the processor what a change of the active set costs: the most instructions of one solve of the preview
// law in float, for each number of changes. The random programs of the shipped vehicle jump from one to the next, so
// that the kept active set helps in some and misleads in others. host_tests/figures (image.active_set) reads the output
// and derives the cost of the cap from it.
#include <algorithm>
#include <array>
#include <cstdint>

#include "firmware/mpc/generated/gain_table.h"
#include "firmware/mpc/horizontal_mpc.h"
#include "hal/cortex_m/mps2.h"
#include "hal/cortex_m/semihosting.h"

namespace {

using namespace m100;
using hal::print;

constexpr int kPrograms = 20000;
constexpr std::size_t kMaxChangesSeen = 2 * mpc::kMaxChanges;  // two tries per solve
constexpr std::int64_t kInstructionsPerCycle = 40;             // -icount shift=0: 1 ns per instruction, 40 ns per cycle

hal::SysTickClock system_clock(hal::mps2::systick(), hal::mps2::kClock_hz, 10000);

struct Cost {
  std::uint32_t solves = 0;
  std::uint64_t worst_cycles = 0;
};
std::array<Cost, kMaxChangesSeen + 1> costs;
std::uint32_t clipped = 0;

/// Uniform in [-size, size], from a fixed start.
float random_number(float size) {
  static std::uint32_t state = 1;
  state = state * 1664525U + 1013904223U;
  return size * (static_cast<float>(state >> 8U) / 8388608.F - 1.F);
}

/// Distances and speeds are large on purpose, or small: limits bind nearly everywhere, or hardly ever.
mpc::Problem<float> random_program() {
  mpc::Problem<float> program;
  const float size = random_number(1.F) > 0.F ? 1.F : 0.2F;
  program.state = {random_number(20.F * size), random_number(8.F * size), random_number(0.5F), random_number(2.F)};
  program.previous_input_slope = random_number(0.46F);
  program.disturbance_m_s2 = random_number(3.F);
  program.input_offset_slope = random_number(0.03F);
  program.constant_targets = random_number(1.F) > 0.F;
  const float jump_m = random_number(5.F * size);
  const auto jumps_at = static_cast<std::size_t>(10.F + random_number(9.F));
  for (std::size_t i = 0; i < mpc::kHorizon; ++i) {
    program.position_ref_m[i] = i < jumps_at ? -jump_m : jump_m;
    program.velocity_ref_m_s[i] = random_number(2.F * size);
    program.tilt_ref_slope[i] = random_number(0.3F);
    program.input_ref_slope[i] = random_number(0.3F);
  }
  return program;
}

void solve_some(mpc::HorizontalMpc<float>& law) {
  mpc::Solution<float> solution;
  for (int i = 0; i < kPrograms; ++i) {
    const mpc::Problem<float> program = random_program();
    const std::uint64_t before = system_clock.cycles();
    law.solve_preview(program, solution);
    const std::uint64_t spent = system_clock.cycles() - before;
    clipped += solution.path == mpc::Path::kClipped ? 1U : 0U;
    if (solution.path == mpc::Path::kActiveSet) {
      Cost& cost = costs[std::min<std::size_t>(solution.changes, kMaxChangesSeen)];
      ++cost.solves;
      cost.worst_cycles = std::max(cost.worst_cycles, spent);
    }
  }
}

}  // namespace

extern "C" void SysTick_Handler() { system_clock.on_period(); }

int main() {
  system_clock.start();
  static mpc::HorizontalMpc<float> x(mpc::generated::kX<float>);
  static mpc::HorizontalMpc<float> y(mpc::generated::kY<float>);
  solve_some(x);
  solve_some(y);
  for (std::size_t changes = 0; changes < costs.size(); ++changes) {
    if (costs[changes].solves > 0) {
      print("changes ");
      print(static_cast<std::int64_t>(changes));
      print(" solves ");
      print(static_cast<std::int64_t>(costs[changes].solves));
      print(" worst ");
      print(kInstructionsPerCycle * static_cast<std::int64_t>(costs[changes].worst_cycles));
      print("\n");
    }
  }
  print("clipped ");
  print(static_cast<std::int64_t>(clipped));
  print("\n");
  return 0;
}
