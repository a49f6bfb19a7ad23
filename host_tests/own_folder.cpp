// SPDX-License-Identifier: BSD-3-Clause
#include <sys/types.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace {

/// Gives every test program its own folder for temporary files and removes it at the end, so that tests that run at the
/// same time may write files of the same name. GoogleTest, std::filesystem and every program that a test starts find
/// the folder in $TMPDIR.
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
    if (::getpid() == owner_) {  // not in a child that a test has forked
      std::filesystem::remove_all(path_, ignored);
    }
  }

 private:
  std::string path_;
  pid_t owner_ = ::getpid();
};

const OwnFolder own_folder;

}  // namespace
