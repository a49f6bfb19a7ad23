// SPDX-License-Identifier: BSD-3-Clause
// Letters beyond ASCII: allowed in quotes and comments, refused elsewhere. What TOML nodes give and refuse.
#include "firmware/companion/files/text/toml_text.h"

#include <gtest/gtest.h>

#include <string>

#include "host_tests/refusal.h"

namespace m100::companion {
namespace {

std::string refusal_of(std::string_view text) {
  return host_tests::refusal_by<FileError>([&] { (void)parse_toml(text, "f"); });
}

/// The line of the message "f:LINE: what"; 0: the text is accepted.
long refused_at(std::string_view text) {
  const std::string refusal = refusal_of(text);
  EXPECT_TRUE(refusal.empty() || refusal.starts_with("f:")) << refusal;
  return refusal.empty() ? 0 : std::stol(refusal.substr(2));
}

TEST(TomlText, StringsKeepEveryLanguage) {
  const auto table = parse_toml(
      "\xEF\xBB\xBF# Höhe, 高さ\na = \"Höhe \\\" ü\" # größer\n\"größe\" = 'C:\\\\höhe \"x\"'\nb = \"\"\"ä # "
      "\"\n😀\"\"\"\n"
      "c = 'plain \\n'\nd = \"\"\ne = ''\nf = '''\nzwei\nZeilen ß'''",
      "f");
  EXPECT_EQ(table.get("a")->text(), "Höhe \" ü");
  EXPECT_EQ(table.get("größe")->text(), "C:\\\\höhe \"x\"");
  EXPECT_EQ(table.get("b")->text(), "ä # \"\n😀");
  EXPECT_EQ(table.get("c")->text(), "plain \\n");
  EXPECT_EQ(table.get("d")->text(), "");
  EXPECT_EQ(table.get("e")->text(), "");
  EXPECT_EQ(table.get("f")->text(), "zwei\nZeilen ß");
  EXPECT_EQ(table.get("f")->line(), 9);
}

TEST(TomlText, RefusesALetterOutsideQuotesByItsLine) {
  EXPECT_EQ(refused_at("a = 1\ngröße = 2\n"), 2);
  EXPECT_EQ(refused_at("time = { column = \"t\", time \xCF\x85. }\n"), 1);  // found by the fuzzer
  EXPECT_EQ(refused_at("# ä\n\na = 1\xC2\xA0\n"), 3);                       // a non-breaking space
  EXPECT_NE(refusal_of("a = 1\ngröße = 2\n").find("double quotes"), std::string::npos)
      << refusal_of("a = 1\ngröße = 2\n");
  EXPECT_NE(refusal_of("a = ü\n").find("double quotes"), std::string::npos) << refusal_of("a = ü\n");
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
  EXPECT_EQ(refused_at(name(16, "a") + " = 1\n"), 0);
  EXPECT_EQ(
      refused_at("a = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8]\n"),
      0);
  EXPECT_EQ(refused_at("# " + name(100, "a") + "\ns = \"" + name(100, "a") + "\"\n"), 0);
  std::string nested = "1";
  for (int k = 0; k < 200; ++k) {
    nested = "{ " + name(17, "a") + " = " + nested + " }";
  }
  EXPECT_EQ(refused_at("a = " + nested + "\n"), 1);
}

TEST(TomlText, WhatIsLeftOpenIsRefused) {
  for (const char* open : {"\n\"ä", "\n'ä", "\na = \"\"\"ä", "\na = '''", "\na = 'ä\n'", "\na = \"ä\\"}) {
    EXPECT_GE(refused_at(open), 2) << open;
  }
}

// Catches two keys that are taken for the same because only their letters beyond ASCII differ.
TEST(TomlText, KeysThatDifferInOneLetterAreTwo) {
  EXPECT_EQ(refused_at("\"größe\" = 1\n\"grüße\" = 2\n"), 0);
  EXPECT_EQ(refused_at("\"größe\" = 1\n\"größe\" = 2\n"), 2);
}

TEST(TomlText, ANodeIsRefusedByItsLineAndItsFullName) {
  const TomlNode root =
      parse_toml("[axis.roll]\nscale = 9\nshape = \"jump\"\nlist = [1, \"a\"]\non = true\n", "v.toml");
  const TomlNode& table = *root.get("axis")->get("roll");
  const auto refusal = [](const auto& use) { return host_tests::refusal_by<FileError>(use); };
  EXPECT_EQ(table.get("scale")->number(9.0, 9.0), 9.0);
  EXPECT_TRUE(table.get("on")->flag());
  EXPECT_EQ(table.get("none"), nullptr);
  EXPECT_EQ(refusal([&] { (void)table.get("scale")->number(10.0, 20.5); }),
            "v.toml:2: 'axis.roll.scale': 9 is outside [10, 20.5]");
  EXPECT_EQ(refusal([&] { (void)table.get("shape")->number(); }), "v.toml:3: 'axis.roll.shape': must be a number");
  EXPECT_EQ(refusal([&] { (void)table.get("scale")->flag(); }), "v.toml:2: 'axis.roll.scale': must be true or false");
  EXPECT_EQ(refusal([&] { (void)table.get("list")->table(); }), "v.toml:4: 'axis.roll.list': must be a table");
  EXPECT_EQ(refusal([&] { (void)table.get("list")->entries()[1].number(); }),
            "v.toml:4: 'axis.roll.list': must be a number");
  EXPECT_EQ(refusal([&] { table.refuse_without("damping", "is missing"); }),
            "v.toml:1: 'axis.roll.damping': is missing");
}

}  // namespace
}  // namespace m100::companion
