// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace m100::lab::evening {

/// What is there: asked once, kept in the state file.
struct Settings {
  std::string port;       ///< of the autopilot, as the board names it
  std::string pose_port;  ///< of the pose
  std::uint32_t baud = 230400;
  std::uint32_t pose_baud = 115200;
  std::uint32_t app_id = 0;
  std::string key_file;       ///< on the board; empty: commands go plain
  std::string m100 = "m100";  ///< the program as this machine calls it, for its step `check`
};

/// A file that a step made, or that a person put there.
struct MadeFile {
  std::string sha256;
  std::string made_by;                      ///< name of the step
  std::map<std::string, std::string> from;  ///< file and its SHA-256 at that time
};

/// Writes a file by another name first: it is there whole, or as it was before. Errors: InputError.
void write_file(const std::string& path, std::string_view bytes);

/// Makes the folder where there is none. @returns its path. Errors: InputError.
std::string made(const std::string& path);

/// One aircraft's folder: evening.json in it says what is done and which file was made from which. Names of files are
/// relative to the folder.
class Folder {
 public:
  /// Reads evening.json, or begins a new folder where there is none. Errors: InputError.
  explicit Folder(const std::string& path);

  const std::string& path() const { return path_; }
  Settings& settings() { return settings_; }
  const Settings& settings() const { return settings_; }
  const std::map<std::string, MadeFile>& files() const { return files_; }

  std::string file(const std::string& name) const;
  bool has(const std::string& name) const;
  bool is_done(const std::string& step) const;

  /// The step is done: notes what it made, from what, with the hashes as they are now.
  void done(const std::string& step, const std::vector<std::string>& makes, const std::vector<std::string>& reads);
  /// These files are there as the step was once done with them.
  bool was_taken(const std::string& step, const std::vector<std::string>& makes) const;
  /// What is put there next under these names is new.
  void forget(const std::vector<std::string>& makes);
  /// The step, and every step that used one of its files, is to be done again.
  void again(const std::string& step);
  /// Looks at every file that is noted. A step whose file is gone, or was made from a file that is another now, is to
  /// be done again. @returns one sentence for each change that was found.
  std::vector<std::string> look_for_changes();
  /// What the evening has measured, by name; kept in the state file.
  void note(const std::string& name, double value) { numbers_[name] = value; }
  const std::map<std::string, double>& numbers() const { return numbers_; }

  /// Writes evening.json, by another name first. @param next what is to be done, for other programs.
  void save(const nlohmann::json& next) const;

 private:
  /// Every step that used the file as it was before is to be done again. @returns their names, quoted.
  std::string again_after(const std::string& name, const std::string& sha256);

  std::string path_;
  Settings settings_;
  std::vector<std::string> done_;
  std::map<std::string, MadeFile> files_;
  std::map<std::string, double> numbers_;
};

/// 64 hexadecimal digits of a file's SHA-256; empty: there is no such file.
std::string sha256_of(const std::string& path);

}  // namespace m100::lab::evening
