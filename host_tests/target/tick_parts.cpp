// SPDX-License-Identifier: BSD-3-Clause
// Prints the instructions of a tick by part (promise R7): arguments RECORDING flight|hostile. For each part: the share
// of the ticks in which it runs, the median of those, and the worst. The last part needs a log, which the image does
// not have in flight, so it is measured in a separate run.
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "hal/cortex_m/mps2.h"
#include "hal/cortex_m/semihosting.h"
#include "host_tests/target/parts.h"
#include "host_tests/target/recording_player.h"

namespace {

using namespace m100;
using hal::print;

constexpr std::size_t kMaxTicks = 20000;
constexpr std::int64_t kInstructionsPerCycle = 40;  // -icount shift=0: 1 ns per instruction, 40 ns per cycle

hal::SysTickClock system_clock(hal::mps2::systick(), hal::mps2::kClock_hz, 10000);
std::array<std::array<std::uint32_t, kMaxTicks>, target::kParts> cycles;

std::size_t fly(bool logged, std::string_view path, bool hostile) {
  using Flight = golden::ReplayedFlight<float, float>;
  static Flight without_log(false, true);
  static Flight with_log(true, true);
  Flight& flight = logged ? with_log : without_log;
  const std::size_t ticks = target::play(flight, path, hostile, [&flight](std::size_t tick) {
    target::begin_parts();
    flight.tick();
    const std::array<std::uint32_t, target::kParts>& parts = target::end_parts();
    for (std::size_t part = 0; part < target::kParts && tick < kMaxTicks; ++part) {
      cycles[part][tick] = parts[part];
    }
  });
  return std::min(ticks, kMaxTicks);
}

void print_column(std::int64_t value) {
  for (std::int64_t smallest = 10000000; smallest > 1 && value < smallest; smallest /= 10) {
    print(" ");
  }
  print(value);
}

void print_part(std::size_t part, std::size_t ticks) {
  const std::span<std::uint32_t> of_tick = std::span(cycles[part]).first(ticks);
  std::sort(of_tick.begin(), of_tick.end());
  const auto first = static_cast<std::size_t>(std::upper_bound(of_tick.begin(), of_tick.end(), 0U) - of_tick.begin());
  const std::span<std::uint32_t> ran = of_tick.subspan(first);
  print_column(static_cast<std::int64_t>(100 * ran.size() / ticks));
  print_column(ran.empty() ? 0 : kInstructionsPerCycle * ran[ran.size() / 2]);
  print_column(ran.empty() ? 0 : kInstructionsPerCycle * ran.back());
  print("  ");
  print(target::kPartNames[part]);
  print("\n");
}

}  // namespace

extern "C" void SysTick_Handler() { system_clock.on_period(); }

int main() {
  system_clock.start();
  // All arguments are views into the same buffer, so the name of the recording is fetched last.
  const bool hostile = hal::argument(2) == "hostile";
  const std::string_view path = hal::argument(1);
  const std::size_t ticks = fly(false, path, hostile);
  if (ticks == 0) {
    return 1;
  }
  print("  % of ticks  median   worst  instructions of\n");
  for (std::size_t part = 0; part + 1 < target::kParts; ++part) {
    print_part(part, ticks);
  }
  fly(true, path, hostile);
  print_part(target::kParts - 1, ticks);
  return 0;
}
