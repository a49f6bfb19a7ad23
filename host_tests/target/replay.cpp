// SPDX-License-Identifier: BSD-3-Clause
// The recorded flight on the processor itself: arguments TAPE [hash|cost]. "hash" prints one SHA-256 for each scalar
// (promise R6), "cost" the cycles of each tick of the float build without a log (promise R7): best, median, worst.
#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

#include "hal/cortex_m/mps2.h"
#include "hal/cortex_m/semihosting.h"
#include "hal/cortex_m/stack_paint.h"
#include "host_tests/golden/flight/tape.h"

namespace {

using namespace m100;
using hal::print;

hal::SysTickClock system_clock(hal::mps2::systick(), hal::mps2::kClock_hz, 10000);
golden::TapeTick tape_tick;
std::array<std::uint32_t, 20000> cost_cycles;

/// @returns ticks replayed.
template <typename T, typename S>
std::size_t replay(golden::TapeFlight<T, S>& flight, std::string_view path) {
  hal::HostFile file(path);
  if (!file.is_open()) {
    return 0;
  }
  std::size_t ticks = 0;
  while (golden::read_tick(tape_tick, [&file](std::span<std::byte> into) { return file.read(into).size(); })) {
    flight.load(tape_tick);
    const std::uint64_t before = system_clock.cycles();
    flight.tick();
    cost_cycles[ticks % cost_cycles.size()] = static_cast<std::uint32_t>(system_clock.cycles() - before);
    flight.drain();
    ++ticks;
  }
  return ticks;
}

template <typename T, typename S>
bool print_hash(std::string_view name, std::string_view path) {
  static golden::TapeFlight<T, S> flight;
  const std::size_t ticks = replay(flight, path);
  const golden::HashText text = flight.finish();
  print(name);
  print(golden::view(text));
  print(" ");
  print(static_cast<std::int64_t>(ticks));
  print(" ticks\n");
  return ticks > 0 && text[0] != '\0';
}

bool print_cost(std::string_view path) {
  static golden::TapeFlight<float, float> flight(false);
  const std::size_t ticks = std::min(replay(flight, path), cost_cycles.size());
  if (ticks == 0) {
    return false;
  }
  std::sort(cost_cycles.begin(), cost_cycles.begin() + static_cast<std::ptrdiff_t>(ticks));
  constexpr std::int64_t kInstructionsPerCycle = 40;  // -icount shift=0: 1 ns an instruction, 40 ns a cycle
  print("tick_instructions best ");
  print(kInstructionsPerCycle * cost_cycles[0]);
  print(" median ");
  print(kInstructionsPerCycle * cost_cycles[ticks / 2]);
  print(" worst ");
  print(kInstructionsPerCycle * cost_cycles[ticks - 1]);
  print("\n");
  return true;
}

}  // namespace

extern "C" void SysTick_Handler() { system_clock.on_period(); }

int main() {
  system_clock.start();
  // Each argument is a view into the same buffer: the tape's name is fetched again where it is used.
  const bool cost = hal::argument(2) == "cost";
  const std::string_view path = hal::argument(1);
  const bool done = cost ? print_cost(path)
                         : print_hash<double, double>("double ", path) && print_hash<float, float>("float  ", path) &&
                               print_hash<float, core::Fixed>("fixed  ", path);
  return done ? 0 : 1;
}
