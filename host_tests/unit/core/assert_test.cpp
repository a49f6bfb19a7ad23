// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/core/assert.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>

namespace m100::core {
namespace {

void end_with_its_line(const char* file, int line) {
  std::fprintf(stderr, "%s at %d\n", file, line);
  std::exit(line);
}
void come_back(const char*, int) {}

// Catches a failed assertion after which the program goes on: the handler gets the place, and if it returns, the
// program is stopped.
TEST(AssertionDeathTest, CallsTheHandlerAndNeverReturns) {
  EXPECT_EQ(set_assertion_handler(&end_with_its_line), nullptr) << "by default there is none";
  EXPECT_EXIT(assertion_failed("part.cpp", 17), ::testing::ExitedWithCode(17), "part.cpp at 17");
  EXPECT_EXIT(
      M100_ASSERT(1 == 2), [](int status) { return WIFEXITED(status); }, "assert_test.cpp at");
  M100_ASSERT(1 == 1);
  EXPECT_EQ(set_assertion_handler(&come_back), &end_with_its_line);
  EXPECT_DEATH(assertion_failed("part.cpp", 17), "");
  EXPECT_EQ(set_assertion_handler(nullptr), &come_back);
  EXPECT_DEATH(assertion_failed("part.cpp", 17), "");
}

}  // namespace
}  // namespace m100::core
