// SPDX-License-Identifier: BSD-3-Clause
// Letters beyond ASCII: allowed in quotes and comments, refused elsewhere, and never passed to toml++.
#include "firmware/companion/files/text/toml_text.h"

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
  EXPECT_EQ(refused_at("# ä\n\na = 1\xC2\xA0\n"), 3);                       // a non-breaking space
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

// A megabyte of "a.a.a" once overflowed the stack. toml++ itself refuses names that are nested in other ways.
TEST(TomlText, ANameOfTooManyPartsIsRefusedByItsLine) {
  const auto name = [](int parts, const std::string& part) {
    std::string out = part;
    for (int k = 1; k < parts; ++k) {
      out += "." + part;
    }
    return out;
  };
  for (const std::string part : {"a", "1", "\"b\"", "'c'", " d "}) {
    for (const int parts : {18, 1000000}) {
      EXPECT_EQ(refused_at("x = 1\n" + name(parts, part) + " = 1\n"), 2) << part;
      EXPECT_EQ(refused_at("\n\n[" + name(parts, part) + "]\n"), 3) << part;
      EXPECT_EQ(refused_at("y = { " + name(parts, part) + " = 1 }\n"), 1) << part;
    }
  }
  EXPECT_EQ(refused_at(name(17, "a") + " = 1\n"), 0);
  EXPECT_EQ(
      refused_at("a = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8]\n"),
      0);
  EXPECT_EQ(refused_at("# " + name(100, "a") + "\ns = \"" + name(100, "a") + "\"\n"), 0);
  std::string nested = "1";
  for (int k = 0; k < 200; ++k) {
    nested = "{ " + name(17, "a") + " = " + nested + " }";
  }
  EXPECT_EQ(refused_at("a = " + nested + "\n"), 0);
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
