// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/operator/line_writer.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace m100::companion {
namespace {

using namespace std::chrono_literals;

std::atomic<bool> stands_still{false};
std::atomic<bool> writes{false};
std::vector<std::string> written;

/// An output that stands still as a disk does: write() returns when it moves again.
void write_when_it_moves(int /*descriptor*/, std::string_view text) {
  writes = true;
  while (stands_still) {
    std::this_thread::sleep_for(1ms);
  }
  written.emplace_back(text);
}

struct LineWriterTest : ::testing::Test {
  LineWriterTest() {
    written.clear();
    stands_still = false;
    writes = false;
  }
};

TEST_F(LineWriterTest, LinesLeaveInTheirOrderAndWhole) {
  LineWriter writer(false, &write_when_it_moves);
  writer.push("first");
  writer.push("second");
  writer.push(std::string(2000, 'x'));
  writer.finish();
  std::string cut(TextLine::kMaxBytes, 'x');
  cut.back() = '\n';
  EXPECT_EQ(written, (std::vector<std::string>{"first\n", "second\n", cut}));
}

// The status line is erased before each line and at the end.
TEST_F(LineWriterTest, AStatusLineStandsBelowTheLines) {
  LineWriter writer(true, &write_when_it_moves);
  writer.push("first");
  for (std::uint32_t tick = 0; tick <= LineWriter::kTicksPerStatus; ++tick) {
    writer.show({});
  }
  writer.push(std::string(2000, 'x'));
  writer.finish();
  ASSERT_EQ(written.size(), 5U) << "two lines, two states, and the end";
  for (const std::string& text : written) {
    EXPECT_TRUE(text.starts_with("\r\x1b[K"));
    EXPECT_LE(text.size(), TextLine::kMaxBytes);
  }
  EXPECT_EQ(written.front(), "\r\x1b[Kfirst\n");
  EXPECT_EQ(written.back(), "\r\x1b[K");
}

// Catches a flying thread that writes by itself, or waits for the thread that does: this test would never end.
TEST_F(LineWriterTest, AnOutputThatStandsStillDoesNotStopThePusher) {
  LineWriter writer(false, &write_when_it_moves);
  stands_still = true;
  writer.push("0");
  while (!writes) {
    std::this_thread::sleep_for(1ms);
  }
  for (std::size_t line = 1; line <= 3 * LineWriter::kLines; ++line) {
    writer.push(std::to_string(line));
  }
  stands_still = false;
  writer.finish();
  ASSERT_EQ(written.size(), 1 + LineWriter::kLines) << "what finds no room is lost";
  EXPECT_EQ(written.back(), std::to_string(LineWriter::kLines) + "\n") << "the first ones are kept";
}

// Catches a program that never ends, because the disk under its output never moves again.
TEST_F(LineWriterTest, AnOutputThatNeverMovesAgainIsLeftBehind) {
  LineWriter writer(false, &write_when_it_moves, 20ms);
  stands_still = true;
  writer.push("lost");
  writer.finish();
  EXPECT_TRUE(written.empty());
  stands_still = false;
  while (written.empty()) {
    std::this_thread::sleep_for(1ms);  // the thread that was left behind must not touch the next test
  }
}

TEST_F(LineWriterTest, TheCurrentOneIsTheOneThatRuns) {
  EXPECT_EQ(LineWriter::current(), nullptr);
  LineWriter writer(false, &write_when_it_moves);
  EXPECT_EQ(LineWriter::current(), &writer);
  writer.finish();
  EXPECT_EQ(LineWriter::current(), nullptr);
}

}  // namespace
}  // namespace m100::companion
