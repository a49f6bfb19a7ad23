// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/companion/files/pose_options.h"
#include "firmware/companion/files/text/json.h"

namespace m100::lab::evening {

/// The equipment of an evening: given once, kept in the state file.
struct Settings {
  std::string port;  ///< serial port of the autopilot, as the board names it
  std::uint32_t baud = 230400;
  companion::PoseOptions pose;  ///< where the board gets the poses
  std::string bridge;  ///< options of `m100-lab bridge`, which sends them from this machine; empty: it does not
  std::uint32_t app_id = 0;
  int flights = 1;            ///< of the course, before and after the correction
  std::string key_file;       ///< on the board; empty: commands are not encrypted
  std::string m100 = "m100";  ///< the program m100 on this machine, for the step `check`
  bool keep_worse = false;    ///< takes the corrected law even if it is worse as flown
};

/// Calls use(option, key, is_old, member) for every setting: its option, its key in the state file, whether every state
/// file has the key (an older one lacks the others), and a function from Settings to the member.
template <typename Use>
void for_each_setting(const Use& use) {
  use(
      "--port", "port", true, [](auto& of) -> auto& { return of.port; });
  use(
      "--pose-port", "pose_port", true, [](auto& of) -> auto& { return of.pose.port; });
  use(
      "--baud", "baud", true, [](auto& of) -> auto& { return of.baud; });
  use(
      "--pose-baud", "pose_baud", true, [](auto& of) -> auto& { return of.pose.baud; });
  use(
      "--pose-from", "pose_from", false, [](auto& of) -> auto& { return of.pose.from; });
  use(
      "--set-points-from", "set_points_from", false, [](auto& of) -> auto& { return of.pose.set_points_from; });
  use(
      "--mavlink-key", "mavlink_key", false, [](auto& of) -> auto& { return of.pose.key_file; });
  use(
      "--accept-clock", "accept_clock", false, [](auto& of) -> auto& { return of.pose.accept_clock; });
  use(
      "--bridge", "bridge", false, [](auto& of) -> auto& { return of.bridge; });
  use(
      "--app-id", "app_id", true, [](auto& of) -> auto& { return of.app_id; });
  use(
      "--flights", "flights", false, [](auto& of) -> auto& { return of.flights; });
  use(
      "--key-file", "key_file", true, [](auto& of) -> auto& { return of.key_file; });
  use(
      "--m100", "m100", true, [](auto& of) -> auto& { return of.m100; });
  use(
      "--keep-worse", "keep_worse", false, [](auto& of) -> auto& { return of.keep_worse; });
}

/// The board's commands are printed from these options, and must not be refused there. Errors: InputError.
void check_ports(const Settings& settings);
/// @returns the command that sends poses from this machine to the board; empty: none.
std::vector<std::string> bridge_command(const Settings& settings);

/// The record of a file that a step made, or that a person put into the folder.
struct MadeFile {
  std::string sha256;
  std::string made_by;                      ///< name of the step; empty: a person put the file there
  std::map<std::string, std::string> from;  ///< source files, each with its SHA-256 when the step ran
};

/// Replaces a file atomically: writes a partial file, then renames it. Errors: InputError.
void write_file(const std::string& path, std::string_view bytes);

/// Creates the folder if it does not exist. @returns its path. Errors: InputError.
std::string made(const std::string& path);

/// One aircraft's folder. Its evening.json records the steps done and which file was made from which. File names are
/// relative to the folder.
class Folder {
 public:
  /// Creates the folder if needed. Reads evening.json; without one, a new evening begins. Errors: InputError.
  explicit Folder(const std::string& path);

  const std::string& path() const { return path_; }
  Settings& settings() { return settings_; }
  const Settings& settings() const { return settings_; }
  const std::map<std::string, MadeFile>& files() const { return files_; }

  std::string file(const std::string& name) const;
  bool has(const std::string& name) const;
  bool is_done(const std::string& step) const;

  /// Marks the step as done; records the files that it made and read, with their present hashes.
  void done(const std::string& step, const std::vector<std::string>& makes, const std::vector<std::string>& reads);
  /// Whether the step made all of these files, and they are still as recorded; false also if `makes` is empty.
  bool was_taken(const std::string& step, const std::vector<std::string>& makes) const;
  /// Moves the step's files to not_passed, because a log is never overwritten, and removes them from the record.
  void put_aside(const std::string& step, const std::vector<std::string>& makes);
  /// Marks the step, and every step that used one of its files, as to be done again.
  void again(const std::string& step);
  /// Checks every recorded file. A step must be done again if one of its files is missing or was made from a file that
  /// has changed. @returns one sentence for each change that undoes a step.
  std::vector<std::string> look_for_changes();
  /// Records by name a number that the evening has measured, computed or decided; save() writes it.
  void set_number(const std::string& name, double value) { numbers_[name] = value; }
  const std::map<std::string, double>& numbers() const { return numbers_; }
  /// The number of that name; 0: none is recorded.
  double number(const std::string& name) const { return numbers_.contains(name) ? numbers_.at(name) : 0.0; }

  /// Writes evening.json with write_file(). @param next the next step, for other programs.
  void save(const Json& next) const;

 private:
  /// Marks every step that used another version of the file as to be done again. @returns their names, quoted.
  std::string again_after(const std::string& name, const std::string& sha256);

  std::string path_;
  Settings settings_;
  std::vector<std::string> done_;
  std::map<std::string, MadeFile> files_;
  std::map<std::string, double> numbers_;
};

/// The SHA-256 of a file as 64 hexadecimal digits; empty: there is no such file.
std::string sha256_of(const std::string& path);

}  // namespace m100::lab::evening
