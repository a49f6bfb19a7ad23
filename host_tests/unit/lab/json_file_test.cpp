// SPDX-License-Identifier: BSD-3-Clause
// --json writes valid JSON whatever bytes a path contains.
#include "host_tests/lab/json_file.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "host_tests/lab/whole_file.h"

namespace m100::lab {
namespace {

// Catches a campaign that ends with an exception and an empty file after its last flight.
TEST(JsonFile, APathThatIsNoUtf8CostsNothing) {
  const std::string file = (std::filesystem::path(::testing::TempDir()) / "m100_json_file.json").string();
  write_json(file, Json{{"world",
                         "wi\xff"
                         "nd"}});
  EXPECT_EQ(Json::parse(whole_file(file)).at("world"), "wi\xEF\xBF\xBDnd");
  std::filesystem::remove(file);
  EXPECT_EQ(Json("\xff").dump(), "\"\xEF\xBF\xBD\"");
}

TEST(JsonFile, ThatCannotBeWrittenIsSaid) {
  EXPECT_THROW(write_json("/nowhere/answer.json", Json{}), InputError);
  EXPECT_THROW(write_json("/dev/full", Json{}), InputError);
  EXPECT_NO_THROW(write_json("", Json{})) << "none was asked for";
}

}  // namespace
}  // namespace m100::lab
