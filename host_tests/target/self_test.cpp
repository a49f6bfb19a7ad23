// SPDX-License-Identifier: BSD-3-Clause
// The parts on the processor itself: exit status 0 if every check holds, 1 if one does not.
#include <string_view>

#include "hal/cortex_m/semihosting.h"
#include "hal/cortex_m/stack_paint.h"
#include "host_tests/golden/core/maths_sweep.h"

namespace {

using m100::golden::view;
using m100::hal::print;

int failures = 0;

void expect_equal(std::string_view what, std::string_view got, std::string_view wanted) {
  const bool same = got == wanted;
  print(same ? "ok      " : "FAILED  ");
  print(what);
  print("\n");
  if (!same) {
    print("  got    ");
    print(got);
    print("\n  wanted ");
    print(wanted);
    print("\n");
    ++failures;
  }
}

}  // namespace

int main() {
  using namespace m100::golden;
  constexpr int kRounds = kSweepRounds;
  expect_equal("maths in double has the bits of every other machine", view(maths_sweep<double>(kRounds)),
               kSweepOfDouble);
  expect_equal("maths in float has the bits of every other machine", view(maths_sweep<float>(kRounds)), kSweepOfFloat);
  print("stack: ");
  print(std::int64_t{m100::hal::deepest_stack_bytes()});
  print(" of ");
  print(std::int64_t{m100::hal::reserved_stack_bytes()});
  print(" bytes\n");
  return failures == 0 ? 0 : 1;
}
