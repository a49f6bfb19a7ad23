// SPDX-License-Identifier: BSD-3-Clause
// The command line of `m100-lab experiments`: inputs that it refuses before it flies.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "host_tests/lab/subcommands.h"
#include "host_tests/unit/lab/refusal.h"

namespace m100::lab {
namespace {

/// The message with which the subcommand refuses.
std::string refused(std::vector<std::string> words) {
  words.insert(words.begin(), "experiments");
  return refusal_of(add_experiments, words);
}

// Catches a rate that fails an assertion, unknown tasks, and options that have no effect.
TEST(ExperimentsOptions, ThatDoNotGoTogetherAreRefused) {
  for (const char* const rate : {"30", "1000", "nan", "-1"}) {
    for (const char* const kind : {"far", "paper"}) {
      EXPECT_NE(refused({"--tasks", kind, "--rate", rate}).find("--rate: outside the window"), std::string::npos)
          << kind << " " << rate;
    }
  }
  EXPECT_NE(refused({"--only", "hover", "--tasks", "far"}).find("hover"), std::string::npos);
  EXPECT_NE(refused({"--only", "step_30m"}).find("step_30m"), std::string::npos);
  EXPECT_NE(refused({"--tasks", "far", "--report", "."}).find("--report"), std::string::npos);
  EXPECT_NE(refused({"--tasks", "far", "--paper-100-hz"}).find("--paper-100-hz"), std::string::npos);
  EXPECT_NE(refused({"--tasks", "far", "--law", "lqr"}).find("--law"), std::string::npos);
  EXPECT_NE(refused({"--law", "paper", "--mode", "robust"}).find("--mode"), std::string::npos);
  EXPECT_NE(refused({"--law", "paper", "--baseline"}).find("--baseline"), std::string::npos);
}

}  // namespace
}  // namespace m100::lab
