// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/text/printable.h"

#include <gtest/gtest.h>

namespace m100::companion {
namespace {

// Would catch a multi-byte character that is split, or that takes one byte of the next one with it.
TEST(Printable, LeavesWhatATerminalShows) {
  for (const char* text : {"plain text ~", "\xc2\xa0", "gr\xc3\xbc\xc3\x9f", "\xe0\xa0\x80x", "3 \xe2\x82\xac.",
                           "\xed\x9f\xbfy", "\xf0\x9f\x9a\x81!", "\xf0\x90\x80\x80", "\xf4\x8f\xbf\xbfz"}) {
    EXPECT_EQ(printable(text), text);
  }
}

TEST(Printable, EscapesControlCharacters) {
  EXPECT_EQ(printable("a\x1b[2Jb\n\x7f"), "a\\x1b[2Jb\\x0a\\x7f");
  EXPECT_EQ(printable(std::string_view("\0\x1f ", 3)), "\\x00\\x1f ");
  EXPECT_EQ(printable("\xc2\x9b"
                      "2J"),
            "\\xc2\\x9b2J")
      << "U+009B begins an order to a terminal, as ESC [ does";
  EXPECT_EQ(printable("\xc2\x80\xc2\x9f"), "\\xc2\\x80\\xc2\\x9f");
}

// A name from a file that is shown backwards, or on two lines, misleads the reader.
TEST(Printable, EscapesWhatTurnsALineRoundOrEndsIt) {
  EXPECT_EQ(printable("a\xe2\x80\xae"
                      "b"),
            "a\\xe2\\x80\\xaeb");
  for (const char* text : {"\xe2\x80\xa8", "\xe2\x80\xa9", "\xe2\x80\xaa", "\xe2\x81\xa6", "\xe2\x81\xa9"}) {
    EXPECT_EQ(printable(text).size(), 12U) << text;
  }
  for (const char* text : {"\xe2\x80\xa7", "\xe2\x80\xaf", "\xe2\x81\xa5", "\xe2\x81\xaa", "\xe2\x82\xac"}) {
    EXPECT_EQ(printable(text), text);
  }
}

// Would catch a sequence that is accepted because of its first byte alone.
TEST(Printable, EscapesWhatIsNoUtf8) {
  EXPECT_EQ(printable("\x80"), "\\x80") << "a byte that continues nothing";
  EXPECT_EQ(printable("\xc3"), "\\xc3") << "cut off";
  EXPECT_EQ(printable("\xe2\x82"), "\\xe2\\x82");
  EXPECT_EQ(printable("\xf0\x9f\x9a"), "\\xf0\\x9f\\x9a");
  EXPECT_EQ(printable("\xc3("), "\\xc3(");
  EXPECT_EQ(printable("\xe2\x82("), "\\xe2\\x82(");
  EXPECT_EQ(printable("\xf0\x9f\x9a("), "\\xf0\\x9f\\x9a(");
  EXPECT_EQ(printable("\xff\xfe"), "\\xff\\xfe");
}

TEST(Printable, EscapesWhatUtf8Forbids) {
  EXPECT_EQ(printable("\xc0\x9b\xc1\xbf"), "\\xc0\\x9b\\xc1\\xbf") << "ESC in two bytes";
  EXPECT_EQ(printable("\xe0\x82\x9b"), "\\xe0\\x82\\x9b") << "U+009B in three bytes";
  EXPECT_EQ(printable("\xe0\x9f\xbf"), "\\xe0\\x9f\\xbf");
  EXPECT_EQ(printable("\xf0\x8f\xbf\xbf"), "\\xf0\\x8f\\xbf\\xbf");
  EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80") << "half of a pair";
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80") << "past the last character";
  EXPECT_EQ(printable("\xf5\x80\x80\x80"), "\\xf5\\x80\\x80\\x80");
}

TEST(Printable, EndsWhereItIsTooLong) {
  EXPECT_EQ(printable("abcdef", 6), "abcdef");
  EXPECT_EQ(printable("abcdefg", 6), "abcdef...");
  EXPECT_EQ(printable("abcde\xe2\x82\xac!", 6), "abcde\xe2\x82\xac...") << "a character stays whole";
}

}  // namespace
}  // namespace m100::companion
