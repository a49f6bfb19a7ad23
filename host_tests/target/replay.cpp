// SPDX-License-Identifier: BSD-3-Clause
// Replays the recorded flight on the processor: arguments RECORDING hash|cost|hostile|profile.
//   hash     one SHA-256 for each scalar type (promise R6)
//   cost     instructions of each tick of the float build without a log (promise R7): best, median, worst
//   hostile  the same, with the hostile bytes of recording_player.h
//   profile  where those instructions are spent: addresses sampled by the system timer, for linker/profile_report.py
#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

#include "hal/cortex_m/mps2.h"
#include "hal/cortex_m/semihosting.h"
#include "host_tests/target/recording_player.h"

namespace {

using namespace m100;
using hal::print;

hal::SysTickClock system_clock(hal::mps2::systick(), hal::mps2::kClock_hz, 10000);
std::array<std::uint32_t, 20000> cost_cycles;

volatile bool in_tick = false;

/// @returns the number of ticks replayed.
template <typename T, typename S>
std::size_t replay(golden::ReplayedFlight<T, S>& flight, std::string_view path, bool hostile = false) {
  return target::play(flight, path, hostile, [&flight](std::size_t tick) {
    in_tick = true;
    const std::uint64_t before = system_clock.cycles();
    flight.tick();
    cost_cycles[tick % cost_cycles.size()] = static_cast<std::uint32_t>(system_clock.cycles() - before);
    in_tick = false;
  });
}

template <typename T, typename S>
bool print_hash(std::string_view name, std::string_view path) {
  static golden::ReplayedFlight<T, S> flight;
  const std::size_t ticks = replay(flight, path);
  const golden::HashText text = flight.finish();
  print(name);
  print(golden::view(text));
  print(" ");
  print(static_cast<std::int64_t>(ticks));
  print(" ticks\n");
  return ticks > 0 && text[0] != '\0';
}

bool print_cost(std::string_view path, bool hostile) {
  static golden::ReplayedFlight<float, float> flight(false, true);
  const std::size_t ticks = std::min(replay(flight, path, hostile), cost_cycles.size());
  if (ticks == 0) {
    return false;
  }
  std::sort(cost_cycles.begin(), cost_cycles.begin() + static_cast<std::ptrdiff_t>(ticks));
  constexpr std::int64_t kInstructionsPerCycle = 40;  // -icount shift=0: 1 ns per instruction, 40 ns per cycle
  print("tick_instructions best ");
  print(kInstructionsPerCycle * cost_cycles[0]);
  print(" median ");
  print(kInstructionsPerCycle * cost_cycles[ticks / 2]);
  print(" worst ");
  print(kInstructionsPerCycle * cost_cycles[ticks - 1]);
  print("\n");
  return true;
}

/// Program counter and return address: a library function is charged to its caller.
struct Sample {
  std::uint32_t pc;
  std::uint32_t lr;
};
std::array<Sample, 65536> samples;
std::size_t sample_count = 0;

bool print_profile(std::string_view path) {
  static golden::ReplayedFlight<float, float> flight(false, true);
  constexpr std::uint32_t kSamplingCycles = 97;  // prime, so that the samples do not stay in phase with the tick
  hal::mps2::systick().reload = kSamplingCycles - 1;
  hal::mps2::systick().value = 0;
  const std::size_t ticks = replay(flight, path);
  print("ticks ");
  print(static_cast<std::int64_t>(ticks));
  print(" instructions_per_sample ");
  print(std::int64_t{40} * kSamplingCycles);
  print("\n");
  for (const Sample& sample : std::span(samples).first(sample_count)) {
    print(static_cast<std::int64_t>(sample.pc));
    print(" ");
    print(static_cast<std::int64_t>(sample.lr));
    print("\n");
  }
  return ticks > 0 && sample_count < samples.size();
}

}  // namespace

extern "C" {
/// @param frame what the processor pushed: r0 to r3, r12, lr, pc, ...
void on_system_timer(const std::uint32_t* frame) {
  system_clock.on_period();
  if (in_tick && sample_count < samples.size()) {
    samples[sample_count++] = {.pc = frame[6], .lr = frame[5]};
  }
}
[[gnu::naked]] void SysTick_Handler() { asm volatile("mov r0, sp\n b on_system_timer"); }
}

int main() {
  system_clock.start();
  // All arguments are views into the same buffer, so the name of the recording is fetched last.
  const std::string_view mode = hal::argument(2);
  const bool cost = mode == "cost";
  const bool hostile = mode == "hostile";
  const bool profile = mode == "profile";
  const std::string_view path = hal::argument(1);
  if (profile) {
    return print_profile(path) ? 0 : 1;
  }
  if (cost || hostile) {
    return print_cost(path, hostile) ? 0 : 1;
  }
  const bool done = print_hash<double, double>("double ", path) && print_hash<float, float>("float  ", path) &&
                    print_hash<float, core::Fixed>("fixed  ", path);
  return done ? 0 : 1;
}
