// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace m100::lab::loop {

/// Where the logs of the identification flights lie: a folder that the caller keeps, or one of this object's own in the
/// system's place for temporary files, which is removed with it. Two objects never share a folder of their own.
class LogFolder {
 public:
  /// @param kept  an existing folder; empty: one of its own. Errors: InputError where none can be made.
  explicit LogFolder(const std::string& kept);
  ~LogFolder();
  LogFolder(const LogFolder&) = delete;
  LogFolder& operator=(const LogFolder&) = delete;

  std::string file(const std::string& name) const;

 private:
  std::string path_;
  bool own_ = false;
};

}  // namespace m100::lab::loop
