// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/file_use.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

#include "firmware/companion/files/text/regular_file.h"
#include "firmware/companion/files/text/text_file.h"

namespace m100::companion {
namespace {

namespace fs = std::filesystem;

/// Whether two paths name one file: the same path, or links to one file.
bool same_file(const std::string& a, const std::string& b) {
  std::error_code error;
  if (fs::equivalent(a, b, error) && !error) {
    return true;
  }
  const fs::path place_a = fs::weakly_canonical(fs::absolute(a, error), error);
  const fs::path place_b = fs::weakly_canonical(fs::absolute(b, error), error);
  return !error && place_a.lexically_normal() == place_b.lexically_normal();
}

/// Whether two outputs to this path would overwrite each other: true for a regular file, also one that does not exist
/// yet; false for a device such as /dev/null.
bool keeps_one_only(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  return !fs::exists(status) || fs::is_regular_file(status);
}

/// Whether the pipe is a shell's (`| cat`, `>(cat)`, /dev/stdout), which has no name of its own in the file system and
/// opens at once. A pipe of mkfifo waits for a reader when it is opened.
bool is_unnamed_pipe(const std::string& path) {
  struct statfs system {};
  return ::statfs(path.c_str(), &system) == 0 && system.f_type == PIPEFS_MAGIC;
}

/// Whether text may be written to the device: a memory device (null, zero, full, ...); the terminal of this program; or
/// a device that it was given as a standard stream. Any other may be the autopilot's port, or a disk.
bool is_text_device(const struct stat& device) {
  constexpr unsigned kMemoryDevices = 1;
  const dev_t terminal = makedev(5, 0);  // /dev/tty
  if (major(device.st_rdev) == kMemoryDevices || device.st_rdev == terminal) {
    return true;
  }
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    struct stat given {};
    if (::fstat(stream, &given) == 0 && S_ISCHR(given.st_mode) && given.st_rdev == device.st_rdev) {
      return true;
    }
  }
  return false;
}

/// Why the file or device at the path cannot take an output; empty: it can, does not exist, or is a folder.
std::string why_no_place(const std::string& path) {
  struct stat there {};
  if (::stat(path.c_str(), &there) != 0 || S_ISREG(there.st_mode) || S_ISDIR(there.st_mode)) {
    return "";  // a folder is refused by the system later
  }
  if (S_ISFIFO(there.st_mode)) {
    return is_unnamed_pipe(path) ? "" : "is a named pipe, which waits for its reader: give a file, or /dev/stdout";
  }
  return S_ISCHR(there.st_mode) && is_text_device(there) ? "" : "is neither a file nor a device for text";
}

/// Creates files and folders to test whether that is possible; the destructor removes them.
class TrialFile {
 public:
  TrialFile() = default;
  TrialFile(const TrialFile&) = delete;
  TrialFile& operator=(const TrialFile&) = delete;
  ~TrialFile() {
    std::error_code error;
    for (auto made = made_.rbegin(); made != made_.rend(); ++made) {
      fs::remove(*made, error);  // a folder only if it is empty
    }
  }

  /// @returns errno; 0: the folder exists.
  int make_folder(const fs::path& folder) {
    std::error_code error;
    std::vector<fs::path> missing;
    for (fs::path at = folder; !at.empty() && !fs::exists(at, error) && at != at.parent_path(); at = at.parent_path()) {
      missing.push_back(at);
    }
    for (auto at = missing.rbegin(); at != missing.rend(); ++at) {
      if (fs::create_directory(*at, error)) {
        made_.push_back(*at);
      } else if (error) {
        return error.value();
      }
    }
    return fs::is_directory(folder, error) ? 0 : ENOTDIR;
  }

  /// Creates the file if it is missing. @returns errno; 0: the file exists now and can be written.
  int open_file(const std::string& path) {
    std::error_code error;
    const fs::file_status before = fs::status(path, error);
    if (fs::exists(before) && !fs::is_regular_file(before)) {  // why_no_place() has refused unsuitable ones
      return fs::is_directory(before) ? EISDIR : ::access(path.c_str(), W_OK) == 0 ? 0 : errno;
    }
    const int file = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0666);
    if (file < 0) {
      return errno;
    }
    ::close(file);
    if (!fs::exists(before)) {
      made_.push_back(fs::canonical(path, error));  // the target of a link, not the link
    }
    return 0;
  }

 private:
  std::vector<fs::path> made_;
};

}  // namespace

FileUse& FileUse::add(Access kind, const std::string& option, const std::string& path, bool makes_folder) {
  if (!path.empty()) {
    entries_.push_back({.kind = kind, .option = option, .path = path, .makes_folder = makes_folder});
  }
  return *this;
}

FileUse& FileUse::reads(const std::string& option, const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    reads(option, path);
  }
  return *this;
}
FileUse& FileUse::fills(const std::string& option, const std::string& folder, const std::string& file) {
  return folder.empty() ? *this : add(Access::kWritten, option, (fs::path(folder) / file).string(), true);
}

void FileUse::reject_same_file(const Entry& a, const Entry& b) const {
  if ((!a.is_output() && !b.is_output()) || !same_file(a.path, b.path)) {
    return;
  }
  const Entry& output = b.is_output() ? b : a;
  const Entry& other = &output == &b ? a : b;
  if (!other.is_output()) {
    throw FileUseError(output.path + ": is read here as " + other.option + " and would be overwritten by " +
                       output.option);
  }
  if (keeps_one_only(output.path)) {
    throw FileUseError(output.path + ": is named by " + other.option + " and by " + output.option +
                       "; one of them would be lost");
  }
}

void FileUse::reject_overlaps() const {
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      reject_same_file(entries_[j], entries_[i]);
    }
  }
}

void FileUse::reject_existing(const Entry& entry) {
  std::error_code error;
  const fs::file_status there = fs::symlink_status(entry.path, error);
  if (entry.kind == Access::kNamed && (fs::is_regular_file(there) || fs::is_directory(there))) {
    throw FileUseError(entry.path + ": exists already, and " + entry.option + " would take its place");
  }
  if (entry.kind == Access::kCreated && fs::exists(there)) {
    throw FileUseError(entry.path + ": exists already; a log is not overwritten (" + entry.option + ")");
  }
  if (entry.kind == Access::kWritten) {
    if (const std::string why = why_no_place(entry.path); !why.empty()) {
      throw FileUseError(entry.path + ": cannot be written: " + why + " (" + entry.option + ")");
    }
  }
  if (entry.kind != Access::kRead) {
    return;
  }
  std::string why = why_not_read(entry.path);
  why = why.empty() && ::access(entry.path.c_str(), R_OK) != 0 ? "cannot be read" : why;
  if (!why.empty()) {
    throw FileUseError(entry.path + ": " + why + " (" + entry.option + ")");
  }
}

void FileUse::check() const {
  reject_overlaps();
  for (const Entry& entry : entries_) {
    reject_existing(entry);
  }
  TrialFile trial;
  for (const Entry& entry : entries_) {
    if (entry.kind != Access::kWritten && entry.kind != Access::kCreated) {
      continue;
    }
    const int folder = entry.makes_folder ? trial.make_folder(fs::path(entry.path).parent_path()) : 0;
    if (const int why = folder != 0 ? folder : trial.open_file(entry.path); why != 0) {
      throw FileUseError(entry.path + ": cannot be written: " + why_not_written(why) + " (" + entry.option + ")");
    }
  }
  reject_overlaps();  // now that the files exist, dangling links show their targets
}

}  // namespace m100::companion
