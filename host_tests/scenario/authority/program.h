// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace m100::authority {

/// A program as a user starts it: standard input stays open until it is closed, and output goes into a file.
class Program {
 public:
  struct Streams {
    std::string said{};          ///< file for standard output and error
    bool output_closed = false;  ///< the reader has closed it before the program begins
    long file_limit_bytes = 0;   ///< RLIMIT_FSIZE; 0: no limit
    std::string small_disk{};    ///< folder on which a file system of 256 KiB is mounted, only for this program
  };
  /// @throws std::runtime_error
  Program(const std::vector<std::string>& words, const Streams& streams);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  pid_t id() const { return id_; }
  void send(int signal) const;
  /// The child process of this name; -1 if there is none.
  pid_t child(const std::string& name) const;
  void type(const std::string& words) const;  ///< into its standard input
  void close_input();
  /// @returns true while it runs.
  bool runs();
  /// Exit code, or minus the signal that ended it; empty while it runs.
  std::optional<int> ending();

 private:
  pid_t id_ = -1;
  int input_ = -1;
  std::optional<int> ending_;
};

/// Whether this machine lets a user mount a private file system (user namespaces).
bool can_mount();

/// Ends the processes that a killed program has left: all that name the folder on their command line.
void end_all_in(const std::string& folder);

}  // namespace m100::authority
