// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/loop/log_folder.h"

#include <cstdlib>
#include <filesystem>

#include "host_tests/lab/input_error.h"

namespace m100::lab::loop {

namespace fs = std::filesystem;

LogFolder::LogFolder(const std::string& kept) : path_(kept), own_(kept.empty()) {
  if (!own_) {
    return;
  }
  std::error_code error;
  path_ = (fs::temp_directory_path(error) / "m100_loop_XXXXXX").string();
  if (error || mkdtemp(path_.data()) == nullptr) {
    throw InputError(path_, 0, "--logs", "no folder for the flight logs can be created; name one");
  }
}

LogFolder::~LogFolder() {
  if (own_) {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
}

std::string LogFolder::file(const std::string& name) const { return (fs::path(path_) / name).string(); }

}  // namespace m100::lab::loop
