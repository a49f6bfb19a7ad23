// SPDX-License-Identifier: BSD-3-Clause
// Names in the reader's own language: allowed in quotes and comments, refused elsewhere, and never seen by toml++.
#include "firmware/companion/files/toml_text.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace m100::companion {
namespace {

long refused_at(std::string_view text) {
  try {
    static_cast<void>(parse_toml(text));
  } catch (const TomlTextError& wrong) {
    EXPECT_NE(std::string(wrong.what()), "");
    return wrong.line;
  }
  return 0;
}

TEST(TomlText, StringsKeepEveryLanguage) {
  const auto table = parse_toml(
      "\xEF\xBB\xBF# Höhe, 高さ\na = \"Höhe \\\" ü\" # größer\n\"größe\" = 'C:\\\\höhe \"x\"'\nb = \"\"\"ä # "
      "\"\n😀\"\"\"\n"
      "c = 'plain \\n'\nd = \"\"\ne = ''");
  EXPECT_EQ(table["a"].value<std::string>(), "Höhe \" ü");
  EXPECT_EQ(table["größe"].value<std::string>(), "C:\\\\höhe \"x\"");
  EXPECT_EQ(table["b"].value<std::string>(), "ä # \"\n😀");
  EXPECT_EQ(table["c"].value<std::string>(), "plain \\n");
  EXPECT_EQ(table["d"].value<std::string>(), "");
  EXPECT_EQ(table["e"].value<std::string>(), "");
}

TEST(TomlText, RefusesALetterOutsideQuotesByItsLine) {
  EXPECT_EQ(refused_at("a = 1\ngröße = 2\n"), 2);
  EXPECT_EQ(refused_at("time = { column = \"t\", time \xCF\x85. }\n"), 1);  // found by the fuzzer
  EXPECT_EQ(refused_at("# ä\n\na = 1\xC2\xA0\n"), 3);                       // a space that does not break
  EXPECT_EQ(refused_at("a = '''\nx\nä'''\n"), 3);
}

TEST(TomlText, RefusesWhatIsNotUtf8) {
  for (const char* bad : {"\xFF", "\xC0\x80", "\xE0\x80\x80", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xC3", "\xE2\x82"}) {
    EXPECT_EQ(refused_at("\n\na = \"" + std::string(bad) + "\"\n"), 3) << bad;
  }
}

TEST(TomlText, WhatTheLibraryDidNotThinkOfIsRefusedToo) {
  const long line = refused_at("a = 1\n[\nat]xrb = \"v\"\n");
  EXPECT_TRUE(line == 2 || line == 3) << line;
}

TEST(TomlText, WhatIsLeftOpenIsRefused) {
  for (const char* open : {"\n\"ä", "\n'ä", "\na = \"\"\"ä", "\na = '''", "\na = 'ä\n'", "\na = \"ä\\"}) {
    EXPECT_GE(refused_at(open), 2) << open;
  }
}

TEST(TomlText, TheLibrarySeesAsciiAndTheSameLines) {
  const std::string text = ascii_toml("# ä\nb = 'é'\nc = \"\"\"\nü\n\"\"\"\n");
  EXPECT_TRUE(std::all_of(text.begin(), text.end(), [](char c) { return c > 0; }));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 5);
}

}  // namespace
}  // namespace m100::companion
