// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace m100::lab::loop {

/// The folder of the logs of the identification flights: one that the caller keeps, or a temporary one that the object
/// creates and removes. Two objects never share a temporary folder.
class LogFolder {
 public:
  /// @param kept  an existing folder; empty: a new temporary one. Errors: InputError if that cannot be created.
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
