// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace m100::host_tests {

/// All bytes of a file; none if it cannot be read.
inline std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(file), {});
}

/// Writes a file in the program's own folder, in place of a former one. @returns its path.
inline std::string made(const std::string& name, const std::string& content) {
  const std::filesystem::path path = std::filesystem::temp_directory_path() / name;
  std::ofstream(path, std::ios::binary) << content;
  return path.string();
}

/// Each test begins with an empty folder. It goes with the program's own folder: see own_folder.cpp.
struct FolderTest : ::testing::Test {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "test";

  void SetUp() override {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
  }
  std::string path(const std::string& name) const { return (folder / name).string(); }
  std::string made(const std::string& name, const std::string& content) const {
    return host_tests::made("test/" + name, content);
  }
};

}  // namespace m100::host_tests
