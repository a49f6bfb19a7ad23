// SPDX-License-Identifier: BSD-3-Clause
// What a command may do with the files that it is given: each rule by the situation that it is for.
#include "firmware/companion/files/file_use.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "firmware/companion/files/regular_file.h"

namespace m100::companion {
namespace {

namespace fs = std::filesystem;

struct FileUseTest : ::testing::Test {
  const fs::path folder = fs::temp_directory_path() / ("m100_file_use_" + std::to_string(getpid()));
  void SetUp() override { fs::create_directories(folder); }
  void TearDown() override { fs::remove_all(folder); }

  std::string path(const char* name) const { return (folder / name).string(); }
  std::string made(const char* name, const char* text = "kept") const {
    std::ofstream(path(name)) << text;
    return path(name);
  }
  /// @returns the reason, or "" where it is taken.
  static std::string refusal(const FileUse& use) {
    try {
      use.check();
      return "";
    } catch (const FileUseError& wrong) {
      return wrong.what();
    }
  }
  /// Everything in the folder, with the size of what is a file.
  std::vector<std::string> content() const {
    std::vector<std::string> out;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
      out.push_back(entry.path().string() + (entry.is_regular_file() ? std::to_string(entry.file_size()) : "/"));
    }
    std::sort(out.begin(), out.end());
    return out;
  }
};

TEST_F(FileUseTest, TakesWhatCanBeDoneAndLeavesNothingBehind) {
  const std::string in = made("in"), out = made("out");
  fs::create_directory(folder / "there");
  const std::vector<std::string> before = content();
  EXPECT_EQ(refusal(FileUse()
                        .reads("log", in)
                        .reads("logs", std::vector<std::string>{in, in})
                        .holds("--port", "/dev/null")
                        .writes("--json", out)
                        .writes("--table", path("new"))
                        .creates("--log", path("new.ulg"))
                        .names("--link", path("link"))
                        .fills("--folder", path("deep/er"), "a.svg")
                        .fills("--folder", path("deep/er"), "b.svg")
                        .fills("--folder", path("there"), "c.svg")
                        .writes("--none", "")
                        .fills("--none", "", "d.svg")),
            "");
  EXPECT_EQ(content(), before);
  EXPECT_EQ(refusal(FileUse().writes("--a", "/dev/null").writes("--b", "/dev/null")), "") << "a device takes both";
}

TEST_F(FileUseTest, NoOutputIsAnInput) {
  const std::string in = made("in");
  fs::create_symlink(in, folder / "alias");
  fs::create_hard_link(in, folder / "twin");
  const std::string would = ": is read here as log and would be overwritten by --json";
  for (const std::string& out :
       {in, path("alias"), path("twin"), path("./in"), (folder / "x" / ".." / "in").string()}) {
    EXPECT_EQ(refusal(FileUse().reads("log", in).writes("--json", out)), out + would);
    EXPECT_EQ(refusal(FileUse().writes("--json", out).reads("log", in)), out + would) << "in whatever order";
  }
  EXPECT_EQ(refusal(FileUse().holds("log", in).writes("--json", in)), in + would);
  EXPECT_EQ(refusal(FileUse().reads("a", in).reads("b", in).holds("c", in)), "") << "two may read";
  EXPECT_EQ(fs::file_size(in), 4U);
}

TEST_F(FileUseTest, NoTwoOutputsAreOneFile) {
  const std::string lost = ": is named by --a and by --b; one of them would be lost";
  const std::string there = made("there"), not_yet = path("not_yet");
  EXPECT_EQ(refusal(FileUse().writes("--a", there).writes("--b", there)), there + lost);
  EXPECT_EQ(refusal(FileUse().writes("--a", not_yet).creates("--b", not_yet)), not_yet + lost);
  EXPECT_EQ(refusal(FileUse().names("--a", not_yet).creates("--b", not_yet)), not_yet + lost);
  // A link that leads nowhere yet, and the place where it leads.
  fs::create_symlink(not_yet, folder / "ahead");
  EXPECT_EQ(refusal(FileUse().writes("--a", path("ahead")).writes("--b", not_yet)), not_yet + lost);
  EXPECT_FALSE(fs::exists(not_yet));
  EXPECT_TRUE(fs::is_symlink(path("ahead"))) << "the link stays, what it led to is gone again";
}

TEST_F(FileUseTest, WhatIsThereIsNotTakenAway) {
  const std::string there = made("there");
  EXPECT_EQ(refusal(FileUse().creates("--log", there)), there + ": exists already; a log is not overwritten (--log)");
  EXPECT_EQ(refusal(FileUse().names("--sim", there)), there + ": exists already, and --sim would take its place");
  EXPECT_EQ(refusal(FileUse().names("--sim", folder.string())),
            folder.string() + ": exists already, and --sim would take its place");
  fs::create_symlink(path("nowhere"), folder / "old");
  EXPECT_EQ(refusal(FileUse().names("--sim", path("old"))), "") << "a link of before is no loss";
}

TEST_F(FileUseTest, WhatCannotBeReadIsSaid) {
  EXPECT_EQ(refusal(FileUse().reads("log", path("none"))), path("none") + ": cannot be read (log)");
  EXPECT_EQ(refusal(FileUse().reads("log", folder.string())), folder.string() + ": is a folder, no regular file (log)");
  EXPECT_EQ(refusal(FileUse().reads("log", "/dev/zero")),
            "/dev/zero: is no regular file: copy what it gives into one (log)");
  EXPECT_EQ(refusal(FileUse().reads("log", std::vector<std::string>{made("in"), path("none")})),
            path("none") + ": cannot be read (log)");
}

TEST_F(FileUseTest, WhatCannotBeWrittenIsSaid) {
  const std::string in = made("in");
  EXPECT_EQ(refusal(FileUse().writes("--json", path("no/folder"))),
            path("no/folder") + ": cannot be written: No such file or directory (--json)");
  EXPECT_EQ(refusal(FileUse().writes("--json", folder.string())),
            folder.string() + ": cannot be written: Is a directory (--json)");
  EXPECT_EQ(refusal(FileUse().creates("--log", path("in/x"))),
            path("in/x") + ": cannot be written: Not a directory (--log)");
  EXPECT_EQ(refusal(FileUse().fills("--folder", in, "a.svg")),
            in + "/a.svg: cannot be written: Not a directory (--folder)");
  EXPECT_EQ(refusal(FileUse().fills("--folder", in + "/deeper", "a.svg")),
            in + "/deeper/a.svg: cannot be written: Not a directory (--folder)");
  // One that can be written was tried before: it is gone again.
  EXPECT_NE(refusal(FileUse().writes("--a", path("first")).writes("--b", path("no/second"))), "");
  EXPECT_FALSE(fs::exists(path("first")));
  ASSERT_EQ(mkfifo(path("pipe").c_str(), 0600), 0);
  EXPECT_EQ(refusal(FileUse().writes("--json", path("pipe"))), "") << "and nobody waits for its reader";
}

TEST_F(FileUseTest, AFileIsReadWholeUpToItsLimit) {
  const std::string in = made("in", "12345678");
  EXPECT_EQ(read_regular(in, 8).bytes, "12345678");
  EXPECT_EQ(read_regular(in, 8).why_not, "");
  EXPECT_EQ(read_regular(in, 7).why_not, "is larger than 0 MiB");
  EXPECT_EQ(read_regular(in, 7).bytes, "");
  EXPECT_EQ(read_regular(path("none")).why_not, "cannot be read");
  std::ofstream(path("large")).close();
  fs::resize_file(path("large"), (std::uintmax_t{3} << 20U) + 1);
  EXPECT_EQ(read_regular(path("large"), std::uintmax_t{3} << 20U).why_not, "is larger than 3 MiB");
  EXPECT_EQ(kMostTextBytes, 16777216U);
  EXPECT_GE(kMostFileBytes, 536870912U);
}

}  // namespace
}  // namespace m100::companion
