// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <stdexcept>

namespace m100::companion {

class CommandLine;

/// Exit codes of the program (documented in --help).
enum ExitCode : int { kDone = 0, kAnswerIsNo = 1, kBadInput = 2 };

/// Wrong use or bad input: one clear line on stderr, exit code 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The answer is no, and the subcommand has printed it: exit code 1.
class AnswerIsNo : public std::exception {};

// Each function adds one subcommand, which throws UsageError for bad input and AnswerIsNo when the answer is no.
void add_check(CommandLine& m100);
void add_doctor(CommandLine& m100);
void add_fly(CommandLine& m100);
void add_handshake(CommandLine& m100);
void add_probe(CommandLine& m100);  ///< another word for what doctor --port tells of the line
void add_record(CommandLine& m100);
void add_replay(CommandLine& m100);

}  // namespace m100::companion
