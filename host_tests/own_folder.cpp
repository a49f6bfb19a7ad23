// SPDX-License-Identifier: BSD-3-Clause
#include <sys/types.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace {

/// Every test program has a folder for temporary files of its own, removed when it ends: tests that run at the same
/// time may then write files of one name. $TMPDIR is where GoogleTest, std::filesystem and every program that a test
/// starts look for it.
class OwnFolder {
 public:
  OwnFolder() {
    std::error_code error;
    path_ = (std::filesystem::temp_directory_path(error) / "m100_test_XXXXXX").string();
    if (error || ::mkdtemp(path_.data()) == nullptr || ::setenv("TMPDIR", path_.c_str(), 1) != 0) {
      std::abort();  // the tests would write over each other's files
    }
  }
  OwnFolder(const OwnFolder&) = delete;
  OwnFolder& operator=(const OwnFolder&) = delete;
  ~OwnFolder() {
    std::error_code ignored;
    if (::getpid() == owner_) {  // and not a child that a test has forked
      std::filesystem::remove_all(path_, ignored);
    }
  }

 private:
  std::string path_;
  pid_t owner_ = ::getpid();
};

const OwnFolder own_folder;

}  // namespace
