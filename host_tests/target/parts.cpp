// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/target/parts.h"

#include "hal/cortex_m/mps2.h"
#include "hal/cortex_m/systick_clock.h"

namespace m100::target {
namespace {

constexpr std::size_t kDeepest = 16;
constexpr std::size_t kNobody = kParts;

std::array<std::uint32_t, kParts + 1> cycles;
std::array<std::uint32_t, kParts> answer;
struct Call {
  std::size_t caller;
  std::uint32_t return_address;
};
std::array<Call, kDeepest> calls;
std::size_t depth = 0;
std::size_t running = kNobody;
std::uint32_t since = 0;

/// Cycles since `since`. The timer has 24 bits and counts down; a tick is far shorter than its period.
std::uint32_t elapsed() {
  const std::uint32_t now = hal::mps2::systick().value;
  const std::uint32_t reload = hal::mps2::systick().reload;
  return since >= now ? since - now : since + reload + 1 - now;
}

}  // namespace

void begin_parts() {
  cycles = {};
  running = kNobody;
  depth = 0;
  since = hal::mps2::systick().value;
}

const std::array<std::uint32_t, kParts>& end_parts() {
  for (std::size_t part = 0; part < kParts; ++part) {
    answer[part] = cycles[part];
  }
  return answer;
}

}  // namespace m100::target

using namespace m100::target;

// The two functions run between a call and the called function. Arguments and results may be in FPU registers, so they
// use none.
extern "C" {
[[gnu::target("general-regs-only")]] void m100_part_begins(std::size_t part, std::uint32_t return_address) {
  cycles[running] += elapsed();
  calls[depth++ % kDeepest] = {.caller = running, .return_address = return_address};
  running = part;
  since = m100::hal::mps2::systick().value;
}
[[gnu::target("general-regs-only")]] std::uint32_t m100_part_ends() {
  cycles[running] += elapsed();
  const Call& call = calls[--depth % kDeepest];
  running = call.caller;
  since = m100::hal::mps2::systick().value;
  return call.return_address;
}
}

// The called function must find the stack as the caller left it, because some arguments lie there.
#define M100_PART(number, name)
#define M100_PROBE(number, symbol)                                                                      \
  asm(".pushsection .text.probes, \"ax\", %progbits\n.syntax unified\n.thumb\n.balign 2\n.thumb_func\n" \
      ".global __wrap_" #symbol "\n__wrap_" #symbol                                                     \
      ":\n"                                                                                             \
      "push {r0-r4, lr}\nmovs r0, #" #number                                                            \
      "\nmov r1, lr\nbl m100_part_begins\npop {r0-r4, lr}\n"                                            \
      "bl __real_" #symbol "\npush {r0-r3}\nbl m100_part_ends\nmov lr, r0\npop {r0-r3}\nbx lr\n.popsection\n");
#include "host_tests/target/parts.inc"
