// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace m100::companion {

/// An unusable file of a command, in one line that names the file and the option.
class FileUseError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The files that a command will read and write, declared before any work. check() verifies that each input can be
/// read, that each output can be written, and that no output is an input or another output, even under another name. An
/// empty path is an option that was not given.
class FileUse {
 public:
  /// A regular file that is read to its end.
  FileUse& reads(const std::string& option, const std::string& path) { return add(Access::kRead, option, path); }
  FileUse& reads(const std::string& option, const std::vector<std::string>& paths);
  /// A path that the command keeps open and that must not be an output: a port.
  FileUse& holds(const std::string& option, const std::string& path) { return add(Access::kHeld, option, path); }
  /// A file that is created or overwritten.
  FileUse& writes(const std::string& option, const std::string& path) { return add(Access::kWritten, option, path); }
  /// A file that must not exist yet.
  FileUse& creates(const std::string& option, const std::string& path) { return add(Access::kCreated, option, path); }
  /// A name in the file system (a link, a socket) that is created by other means than writing.
  FileUse& names(const std::string& option, const std::string& path) { return add(Access::kNamed, option, path); }
  /// A folder, created if missing, in which a file of this name is written.
  FileUse& fills(const std::string& option, const std::string& folder, const std::string& file);

  /// Leaves the file system as it was. Errors: FileUseError.
  void check() const;

 private:
  enum class Access { kRead, kHeld, kWritten, kCreated, kNamed };
  struct Entry {
    Access kind;
    std::string option;
    std::string path;
    bool makes_folder = false;
    bool is_output() const { return kind != Access::kRead && kind != Access::kHeld; }
  };

  FileUse& add(Access kind, const std::string& option, const std::string& path, bool makes_folder = false);
  void reject_same_file(const Entry& a, const Entry& b) const;
  void reject_overlaps() const;
  /// Refuses what exists at the path if it does not suit the intended use.
  static void reject_existing(const Entry& entry);

  std::vector<Entry> entries_;
};

}  // namespace m100::companion
