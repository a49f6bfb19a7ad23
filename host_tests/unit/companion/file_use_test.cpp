// SPDX-License-Identifier: BSD-3-Clause
// How a command may use the files that it is given: one test for each rule, named after its situation.
#include "firmware/companion/files/file_use.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "firmware/companion/files/text/regular_file.h"
#include "host_tests/own_folder.h"
#include "host_tests/refusal.h"

namespace m100::companion {
namespace {

namespace fs = std::filesystem;

struct FileUseTest : host_tests::FolderTest {
  std::string made(const std::string& name, const std::string& text = "kept") const {
    return FolderTest::made(name, text);
  }
  /// @returns the reason of the refusal, or "" if the use is allowed.
  static std::string refusal(const FileUse& use) {
    return host_tests::refusal_by<FileUseError>([&] { use.check(); });
  }
  /// All entries of the folder, with the size of each file.
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
  // A link whose target does not exist yet, and the target itself.
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
  EXPECT_EQ(refusal(FileUse().reads("log", folder.string())),
            folder.string() + ": is a folder, not a regular file (log)");
  EXPECT_EQ(refusal(FileUse().reads("log", "/dev/zero")),
            "/dev/zero: is not a regular file: copy its content into one (log)");
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
  // The message must say why the folder cannot be made, not that it does not exist.
  const std::string sealed = refusal(FileUse().fills("--folder", "/sys/m100", "a.svg"));
  EXPECT_NE(sealed.find("cannot be written: "), std::string::npos) << sealed;
  EXPECT_EQ(sealed.find("No such file"), std::string::npos) << sealed;
  // The first file was created to try it; it must be removed again.
  EXPECT_NE(refusal(FileUse().writes("--a", path("first")).writes("--b", path("no/second"))), "");
  EXPECT_FALSE(fs::exists(path("first")));
}

// Opening a named pipe waits for a reader, which may never come or may have gone when the work is done. Writing to a
// port would send text to the autopilot.
TEST_F(FileUseTest, AnOutputThatWouldWaitOrSpeakToADeviceIsRefused) {
  ASSERT_EQ(mkfifo(path("pipe").c_str(), 0600), 0);
  const std::string no_pipe =
      ": cannot be written: is a named pipe, which waits for its reader: give a file, or /dev/stdout (--json)";
  EXPECT_EQ(refusal(FileUse().writes("--json", path("pipe"))), path("pipe") + no_pipe);
  fs::create_symlink(path("pipe"), folder / "alias");
  EXPECT_EQ(refusal(FileUse().writes("--json", path("alias"))), path("alias") + no_pipe);
  const int reader = open(path("pipe").c_str(), O_RDONLY | O_NONBLOCK);
  EXPECT_EQ(refusal(FileUse().writes("--json", path("pipe"))), path("pipe") + no_pipe) << "it may have gone by then";
  close(reader);
  fs::create_directory(folder / "report");
  ASSERT_EQ(mkfifo(path("report/roll.html").c_str(), 0600), 0);
  EXPECT_NE(refusal(FileUse().fills("--report", path("report"), "roll.html")).find("is a named pipe"),
            std::string::npos);

  const int line = posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_EQ(grantpt(line) + unlockpt(line), 0);
  const std::string port = ptsname(line);
  EXPECT_EQ(refusal(FileUse().writes("--json", port)),
            port + ": cannot be written: is neither a file nor a device for text (--json)");
  close(line);
  const int server = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
  ASSERT_LT(path("socket").copy(address.sun_path, sizeof address.sun_path - 1), sizeof address.sun_path - 1);
  ASSERT_EQ(bind(server, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  EXPECT_NE(refusal(FileUse().writes("--json", path("socket"))).find("is neither a file"), std::string::npos);
  close(server);
}

// `--json /dev/stdout | jq`, `--json >(gzip > a.gz)` and `--json /dev/null` must keep working.
TEST_F(FileUseTest, AShellsOwnPipesAndWhatTakesTextAreOutputs) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  const std::string shells = "/dev/fd/" + std::to_string(ends[1]);
  EXPECT_EQ(refusal(FileUse().writes("--json", shells)), "");
  close(ends[0]);
  EXPECT_EQ(refusal(FileUse().writes("--json", shells)), "") << "nothing waits, whether its reader is there or gone";
  close(ends[1]);
  for (const char* device : {"/dev/null", "/dev/full"}) {
    EXPECT_EQ(refusal(FileUse().writes("--json", device)), "") << device;
  }
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
  EXPECT_EQ(kMaxTextBytes, 16777216U);
  EXPECT_GE(kMaxFileBytes, 536870912U);
}

}  // namespace
}  // namespace m100::companion
