// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace m100::host_tests {

/// Finds a file of the shared material: in $M100_SHARED if that is set, otherwise in ../shared beside the source tree,
/// and at last in golden/vectors, which holds the protocols' vectors and a sample of the MPC instances. Measured logs
/// are never part of the project. Empty if the file is nowhere.
inline std::optional<std::filesystem::path> shared_file(const std::string& name) {
  std::error_code ignored;
  if (const char* root = std::getenv("M100_SHARED"); root != nullptr) {
    const std::filesystem::path path = std::filesystem::path(root) / name;
    if (std::filesystem::exists(path, ignored)) {
      return path;
    }
  }
  for (const char* root : {"../shared", "../../shared", "../../../shared", "host_tests/golden/vectors",
                           "../../host_tests/golden/vectors"}) {
    const std::filesystem::path path = std::filesystem::path(root) / name;
    if (std::filesystem::exists(path, ignored)) {
      return path;
    }
  }
  return std::nullopt;
}

}  // namespace m100::host_tests

// NOLINTBEGIN(bugprone-macro-parentheses): variable is a name to be declared
/// Declares `variable` as the path of a shared file, or skips the test with a message that names the file.
#define M100_SHARED_FILE_OR_SKIP(variable, name)                                                  \
  const auto variable##_found = ::m100::host_tests::shared_file(name);                            \
  if (!variable##_found) {                                                                        \
    GTEST_SKIP() << name << " is not here: set M100_SHARED to the folder of the shared material"; \
  }                                                                                               \
  const std::filesystem::path& variable = *variable##_found
// NOLINTEND(bugprone-macro-parentheses)
