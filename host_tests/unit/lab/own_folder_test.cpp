// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace m100 {
namespace {

namespace fs = std::filesystem;

TEST(OwnFolder, IsWhereTemporaryFilesGo) {
  const fs::path folder = fs::temp_directory_path();
  EXPECT_EQ(fs::path(::testing::TempDir()).parent_path(), folder);
  EXPECT_EQ(folder.filename().string().rfind("m100_test_", 0), 0U);
  EXPECT_TRUE(fs::is_empty(folder)) << "another test writes here";
}

TEST(OwnFolder, StaysWhereAChildEnds) {
  std::ofstream(fs::temp_directory_path() / "kept") << "by its parent";
  const pid_t child = fork();
  if (child == 0) {
    std::exit(0);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(fs::remove(fs::temp_directory_path() / "kept"));
}

TEST(OwnFolder, IsAnotherForEachProgramAndGoesWithIt) {
  const std::string program = fs::read_symlink("/proc/self/exe").string();
  const std::string again = "'" + program + "' --gtest_filter=OwnFolder.IsWhereTemporaryFilesGo >/dev/null";
  EXPECT_EQ(std::system(again.c_str()), 0) << "its folder is empty, though ours may not be";
  EXPECT_TRUE(fs::is_empty(fs::temp_directory_path())) << "the folder of a program that has ended is left";
}

}  // namespace
}  // namespace m100
