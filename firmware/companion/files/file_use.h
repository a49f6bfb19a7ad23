// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace m100::companion {

/// What is wrong with a file that a command was given, in one line that names the file and the option.
class FileUseError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Which files a command is going to read and to write, said before any work: each input can be read, each output has a
/// place, and no output is an input or another output, by whatever name. Every command of both programs that takes a
/// file says here what it does with it; nothing else decides it. An empty path is an option that was not given.
class FileUse {
 public:
  /// A regular file that is read to its end.
  FileUse& reads(const std::string& option, const std::string& path);
  FileUse& reads(const std::string& option, const std::vector<std::string>& paths);
  /// Whatever is held open meanwhile and must not be written to: a port.
  FileUse& holds(const std::string& option, const std::string& path);
  /// A file that is made or overwritten.
  FileUse& writes(const std::string& option, const std::string& path);
  /// A file that must not be there yet.
  FileUse& creates(const std::string& option, const std::string& path);
  /// A name in the file system (a link, a socket) that is made by other means than writing.
  FileUse& names(const std::string& option, const std::string& path);
  /// A folder, made where there is none, that gets a file of this name.
  FileUse& fills(const std::string& option, const std::string& folder, const std::string& file);

  /// Leaves the file system as it was. Errors: FileUseError.
  void check() const;

 private:
  enum class Kind { kRead, kHeld, kWritten, kCreated, kNamed };
  struct Entry {
    Kind kind;
    std::string option;
    std::string path;
    bool makes_folder = false;
    bool is_output() const { return kind != Kind::kRead && kind != Kind::kHeld; }
  };

  FileUse& add(Kind kind, const std::string& option, const std::string& path, bool makes_folder = false);
  void refuse_the_same(const Entry& a, const Entry& b) const;
  void refuse_overlaps() const;
  /// What is there already, or is not there, against what shall be done with it.
  static void refuse_what_is_there(const Entry& entry);

  std::vector<Entry> entries_;
};

}  // namespace m100::companion
