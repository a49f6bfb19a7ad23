// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace m100::lab::evening {

/// A command as typed into a shell: words that contain special characters are quoted.
std::string typed(const std::vector<std::string>& command);

/// Runs a program inside the folder. Its standard output is appended to the file `said`; it shares our standard error.
/// @returns its exit code; 128 plus the number of the signal that ended it. Errors: InputError if the file cannot be
/// written or the program cannot be started.
int run_program(const std::vector<std::string>& command, const std::string& folder, const std::string& log_file);

/// A lock on a folder. Programs that run_program() starts hold it as long as they run, because the last command of a
/// killed evening may still be writing.
class FolderLock {
 public:
  /// Errors: InputError if another evening, or the last command of one, works there.
  explicit FolderLock(const std::string& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace m100::lab::evening
