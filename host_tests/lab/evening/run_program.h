// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace m100::lab::evening {

/// A command as one types it into a shell: words with other characters than plain ones stand in quotes.
std::string typed(const std::vector<std::string>& command);

/// Runs a program inside the folder; what it prints is appended to the file `said`, its errors go to ours.
/// @returns its exit code; 128 and more: the signal that ended it. Errors: InputError, for a file that cannot be
/// written and a program that cannot be started.
int run_program(const std::vector<std::string>& command, const std::string& folder, const std::string& said);

/// The right to work in a folder. Programs that run_program() starts keep it as long as they run: where an evening was
/// killed, its last command may still be writing.
class FolderLock {
 public:
  /// Errors: InputError, where another evening or its last command works there.
  explicit FolderLock(const std::string& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace m100::lab::evening
