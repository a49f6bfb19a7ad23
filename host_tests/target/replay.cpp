// SPDX-License-Identifier: BSD-3-Clause
// The recorded flight on the processor itself: arguments TAPE hash|cost|hostile|profile.
//   hash     one SHA-256 for each scalar (promise R6)
//   cost     instructions of each tick of the float build without a log (promise R7): best, median, worst
//   hostile  the same, with ten milliseconds of a damaged 921600 baud line before the recorded bytes of each tick, and
//   a
//            course whose goals jump so far and so often that the quadratic programs are at their limits
//   profile  where those instructions go: addresses sampled by the system timer, for linker/profile_report.py
#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

#include "hal/cortex_m/mps2.h"
#include "hal/cortex_m/semihosting.h"
#include "host_tests/golden/flight/tape.h"
#include "protocol/crc.h"

namespace {

using namespace m100;
using hal::print;

hal::SysTickClock system_clock(hal::mps2::systick(), hal::mps2::kClock_hz, 10000);
golden::TapeTick tape_tick;
std::array<std::uint32_t, 20000> cost_cycles;

/// As much of a 921600 baud line as the program takes in one tick.
constexpr std::size_t kHostileBytes = app::SerialLink::kBytesPerTick;

/// What a line can do to a parser, in turn: only start bytes; headers with a good checksum and the longest length, one
/// after the other; noise.
std::byte hostile_byte(std::size_t tick, std::size_t at) {
  static std::uint32_t noise = 1;
  constexpr std::array<std::byte, 10> kHeader{std::byte{0xAA}, std::byte{0xFF}, std::byte{0x03}};
  switch (tick % 3) {
    case 0:
      return std::byte{0xAA};
    case 1: {
      const std::uint16_t crc = protocol::crc16(kHeader);
      const std::size_t in_header = at % 12;
      return in_header < 10 ? kHeader[in_header] : static_cast<std::byte>(crc >> (8 * (in_header - 10)));
    }
    default:
      noise = noise * 1664525U + 1013904223U;
      return static_cast<std::byte>(noise >> 24U);
  }
}

void put_hostile_bytes_first(golden::TapeTick& tick, std::size_t number) {
  const std::size_t recorded = tick.head.autopilot_bytes;
  const std::size_t more = recorded < kHostileBytes ? kHostileBytes - recorded : 0;  // the telemetry still gets through
  std::copy_backward(tick.autopilot.begin(), tick.autopilot.begin() + static_cast<std::ptrdiff_t>(recorded),
                     tick.autopilot.begin() + static_cast<std::ptrdiff_t>(recorded + more));
  for (std::size_t i = 0; i < more; ++i) {
    tick.autopilot[i] = hostile_byte(number, i);
  }
  tick.head.autopilot_bytes = static_cast<std::uint16_t>(recorded + more);
}

volatile bool in_tick = false;

/// @returns ticks replayed.
template <typename T, typename S>
std::size_t replay(golden::TapeFlight<T, S>& flight, std::string_view path, bool hostile = false) {
  hal::HostFile file(path);
  if (!file.is_open()) {
    return 0;
  }
  std::size_t ticks = 0;
  while (golden::read_tick(tape_tick, [&file](std::span<std::byte> into) { return file.read(into).size(); })) {
    if (hostile && flight.controller().link().authority().in_control) {
      put_hostile_bytes_first(tape_tick, ticks);
    }
    flight.load(tape_tick);
    in_tick = true;
    const std::uint64_t before = system_clock.cycles();
    flight.tick();
    cost_cycles[ticks % cost_cycles.size()] = static_cast<std::uint32_t>(system_clock.cycles() - before);
    in_tick = false;
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

bool print_cost(std::string_view path, bool hostile) {
  static golden::TapeFlight<float, float> flight(false);
  if (hostile) {
    flight.fly_far_and_often();
  }
  const std::size_t ticks = std::min(replay(flight, path, hostile), cost_cycles.size());
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

/// Where the processor was, and where it would return to: a library function is charged to its caller.
struct Sample {
  std::uint32_t pc;
  std::uint32_t lr;
};
std::array<Sample, 65536> samples;
std::size_t sample_count = 0;

bool print_profile(std::string_view path) {
  static golden::TapeFlight<float, float> flight(false);
  constexpr std::uint32_t kSamplingCycles = 97;  // prime, so that it does not beat with the tick
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
  // Each argument is a view into the same buffer: the tape's name is fetched last.
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
