// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/signature_times_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "firmware/companion/files/text/text_file.h"
#include "host_tests/own_folder.h"
#include "host_tests/refusal.h"

namespace m100::companion {
namespace {

namespace fs = std::filesystem;

mavlink::ReplayMemory two_streams() {
  mavlink::ReplayMemory memory;
  memory.streams[0] = {.from = {9, 197}, .link = 2, .last = 1000};
  memory.streams[1] = {.from = {255, 190}, .link = 0, .last = mavlink::kSignatureTimeMask};
  memory.count = 2;
  memory.newest = mavlink::kSignatureTimeMask;
  return memory;
}

void expect_same(const mavlink::ReplayMemory& a, const mavlink::ReplayMemory& b) {
  EXPECT_EQ(text_of(a, 0), text_of(b, 0));
}

TEST(ReplayMemoryText, IsReadAsItWasWritten) {
  const mavlink::ReplayMemory memory = two_streams();
  const std::string text = text_of(memory, 0);
  EXPECT_NE(text.find("\n  [9, 197, 2, 1000],\n"), std::string::npos) << text;
  expect_same(parse_replay_memory(text, "f"), memory);
  EXPECT_EQ(parse_replay_memory(text_of(memory, 7), "f").streams[0].last, 1007U);
  EXPECT_EQ(parse_replay_memory(text_of(memory, 7), "f").streams[1].last, mavlink::kSignatureTimeMask);
}

// Would catch a keyed flight that accepts old frames because the file was written by an earlier version.
TEST(ReplayMemoryText, OfAnEarlierVersionIsReadAsItWasWritten) {
  const std::string last = std::to_string(mavlink::kSignatureTimeMask);
  expect_same(parse_replay_memory(
                  "# a comment\nnewest " + last + "\nstream 9 197 2 1000\nstream 255 190 0 " + last + "\n", "f"),
              two_streams());
  EXPECT_EQ(parse_replay_memory("newest 5\n", "f").count, 0U);
}

// Would catch a program that takes a damaged memory for an empty one: truncating the file would then allow a replay
// attack.
TEST(ReplayMemoryText, WhatIsDamagedIsRefusedByItsLine) {
  for (const char* const text :
       {"", "newest\n", "newest 5 6\n", "newest -1x\n", "newest 5\nnewest 5\n", "newest 281474976710656\n",
        "newest 5\nstream 1 1 1\n", "newest 5\nstream 256 1 1 1\n", "newest 5\nrubbish 1\n", "stream 1 1 1 1\n",
        "newest = 5.5\n", "newest = -1\n", "newest = \"5\"\n", "newest = 5\nstreams = 3\n", "newest = 5\nstreams = [",
        "newest = 5\nstreams = [[1, 1, 1]]\n", "newest = 5\nstreams = [[1, 1, 1, nan]]\n", "newest = 5\nstream = []\n",
        "streams = []\n"}) {
    EXPECT_THROW((void)parse_replay_memory(text, "key.accepted"), FileError) << text;
  }
  std::string many = "newest 5\n";
  for (int i = 0; i < 17; ++i) {
    many += "stream 1 " + std::to_string(i) + " 1 1\n";
  }
  const std::string said = host_tests::refusal_by<FileError>([&] { (void)parse_replay_memory(many, "key.accepted"); });
  EXPECT_EQ(said.find("key.accepted:18: "), 0U) << said;
  EXPECT_NE(said.find("make a new key"), std::string::npos) << said;
}

TEST(ReplayMemoryText, EveryNumberIsReadUpToItsLastAndRefusedFromTheNextOn) {
  for (const char* const last : {"255, 1, 1, 1", "1, 255, 1, 1", "1, 1, 255, 1", "1, 1, 1, 281474976710655"}) {
    const std::string line = std::string("[") + last + "]";
    EXPECT_NE(text_of(parse_replay_memory("newest = 5\nstreams = [" + line + "]\n", "f"), 0).find(line),
              std::string::npos)
        << line;
  }
  for (const char* const next : {"256, 1, 1, 1", "1, 256, 1, 1", "1, 1, 256, 1", "1, 1, 1, 281474976710656"}) {
    EXPECT_THROW((void)parse_replay_memory(std::string("newest = 5\nstreams = [[") + next + "]]\n", "f"), FileError)
        << next;
  }
}

struct ReplayFileTest : host_tests::FolderTest {
  const std::string key = path("key");
  const std::string path_for = key + ".accepted";
};

TEST_F(ReplayFileTest, OutlivesTheProgram) {
  {
    SignatureTimesFile file(key);
    EXPECT_EQ(file.accepted_before().count, 0U);
    file.start();
    file.finish(two_streams());
  }
  const SignatureTimesFile again(key);
  expect_same(again.accepted_before(), two_streams());
  struct stat status {};
  ASSERT_EQ(stat(path_for.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
  EXPECT_FALSE(fs::exists(path_for + ".new"));
}

// A killed program cannot save its memory at the end, so the file must always be ahead of what has been accepted.
TEST_F(ReplayFileTest, AProgramThatIsKilledIsRememberedFurtherThanItWas) {
  SignatureTimesFile file(key);
  file.start();
  file.offer(two_streams());
  while (parse_replay_memory(read_file(path_for), path_for).count == 0) {  // bounded by ctest's time limit
    usleep(1000);
  }
  EXPECT_EQ(parse_replay_memory(read_file(path_for), path_for).streams[0].last, 1000U + SignatureTimesFile::kAhead);
}

TEST_F(ReplayFileTest, WhatCannotBeWrittenIsRefusedBeforeAnythingFlies) {
  EXPECT_THROW(SignatureTimesFile(path("none/key")), UsageError);
  made("key.accepted", "rubbish\n");
  EXPECT_THROW(SignatureTimesFile{key}, FileError);
}

}  // namespace
}  // namespace m100::companion
