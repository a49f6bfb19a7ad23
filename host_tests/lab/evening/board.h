// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "host_tests/lab/evening/steps.h"

namespace m100::lab::evening {

/// The companion board, reached by ssh. One connection serves all calls, so that a password is asked for once. Each
/// call throws InputError if the board cannot be reached; the constructor does not connect.
class Board {
 public:
  /// @param destination as ssh takes it: USER@HOST, or ssh://USER@HOST:PORT
  /// @param folder the evening's folder; on the board its files are in m100_evening/NAME of the user's home.
  Board(std::string destination, std::string folder);
  ~Board();
  Board(const Board&) = delete;
  Board& operator=(const Board&) = delete;

  /// Whether all files that the step makes are on the board; fetch() removes them there.
  bool has_result(const Step& step) const;
  /// Copies the files that the step reads to the board and runs its command there, on a terminal that passes keys and
  /// Ctrl-C to it. Files that an earlier run of the step has left are first moved to the folder not_passed of the
  /// board.
  /// @returns the command's exit code.
  int run(const Step& step) const;
  /// Copies the files that the step made into the folder, and removes them on the board.
  void fetch(const Step& step) const;

 private:
  enum class Terminal { kNone, kOwn };
  /// Runs a shell command in the board's folder. @param in its input; empty: none, or ours with kOwn. @param out its
  /// output; empty: ours
  int call(const std::string& shell, const std::string& in, const std::string& out, Terminal terminal) const;
  int call(const std::string& shell) const { return call(shell, "", "", Terminal::kNone); }

  std::string destination_;
  std::string folder_;
  std::string control_;  ///< folder of the connection's socket
};

}  // namespace m100::lab::evening
