// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>

namespace CLI {
class App;
}  // namespace CLI

namespace m100::companion {

/// Exit codes of the program (documented in --help).
enum ExitCode : int { kDone = 0, kAnswerIsNo = 1, kBadInput = 2 };

/// Wrong use or bad input: one clear line on stderr, exit code 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Each subcommand has a function add_*(); those without a header of their own are declared here. Its callback throws
// UsageError for bad input and CLI::RuntimeError(kAnswerIsNo) when the answer is no.
void add_fly(CLI::App& m100);
void add_replay(CLI::App& m100);

}  // namespace m100::companion
