// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/text/plain_number.h"

#include <gtest/gtest.h>

namespace m100::companion {
namespace {

TEST(PlainNumber, IsDecimalAndFinite) {
  for (const char* text : {"0", "-0", "5", "5.", ".5", "-2.5", "007.5", "1e3", "1E-3", "1e308"}) {
    EXPECT_TRUE(is_plain_number(text)) << text;
  }
  for (const char* text :
       {"",    " ",         " 5",    "5 ",     "5s",  "+5",    "--5",   "0x10", "0x1p3", "nan", "NaN",
        "inf", "-infinity", "1e400", "1e-400", "1,5", "1'000", "1_000", "5\n",  "e5",    "."}) {
    EXPECT_FALSE(is_plain_number(text)) << text;
  }
  EXPECT_FALSE(is_plain_number(std::string_view("5\0", 2)));
}

// strtoull takes a number with a leading zero for octal: 010 is 8.
TEST(PlainNumber, AWholeOneIsDigitsAlone) {
  for (const char* text : {"0", "7", "10", "-3", "18446744073709551615"}) {
    EXPECT_TRUE(is_plain_whole_number(text)) << text;
  }
  for (const char* text : {"", "-", "010", "00", "-01", "+1", "0x10", "0b11", "1e3", "1.0", " 1", "1 ",
                           "18446744073709551616", "99999999999999999999"}) {
    EXPECT_FALSE(is_plain_whole_number(text)) << text;
  }
}

}  // namespace
}  // namespace m100::companion
