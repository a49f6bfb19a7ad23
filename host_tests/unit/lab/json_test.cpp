// SPDX-License-Identifier: BSD-3-Clause
// The value type for JSON: what is written is what the JSON library wrote for the same tree, and what is read is
// refused with a sentence.
#include "firmware/companion/files/text/json.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "host_tests/refusal.h"

namespace m100 {
namespace {

// Catches an object that loses the order of its names, and a list that is taken for an object or the reverse.
TEST(Json, IsWrittenAsItIsBuilt) {
  Json tree{{"z", 1}, {"a", {1.0, -2, true, nullptr}}, {"words", {"b", "a"}}, {"z", 2}};
  tree["map"] = std::map<std::string, std::vector<double>>{{"k", {0.1, std::numeric_limits<double>::quiet_NaN()}}};
  tree["empty"] = {{"list", Json::array()}, {"object", Json::object()}};
  EXPECT_EQ(tree.dump(), R"({"z":1,"a":[1.0,-2,true,null],"words":["b","a"],"map":{"k":[0.1,null]},)"
                         R"("empty":{"list":[],"object":{}}})");
  EXPECT_EQ(Json({{"b", {{"d", 1}, {"c", 2}}}, {"a", 1}}).sorted().dump(1),
            "{\n \"a\": 1,\n \"b\": {\n  \"c\": 2,\n  \"d\": 1\n }\n}");
  EXPECT_EQ(Json({{"a", 1}}).dump(), R"({"a":1})");
  EXPECT_EQ(Json("\xC3\xA9 \xff\n").dump(), "\"\xC3\xA9 \xEF\xBF\xBD\\n\"");
  EXPECT_EQ(Json("\xC3\xA9").dump(-1, true), "\"\\u00e9\"");
  tree.erase("map");
  EXPECT_FALSE(tree.contains("map"));
}

// Catches a number that changes on its way through a file: integers of 64 bits, and doubles to the last bit.
TEST(Json, IsReadAsItWasWritten) {
  const Json tree{{"largest", std::numeric_limits<std::uint64_t>::max()},
                  {"least", std::numeric_limits<std::int64_t>::min()},
                  {"third", 1.0 / 3.0},
                  {"float", 0.1F},
                  {"word", "a"},
                  {"list", {1, {{"inner", 2}}}}};
  const Json read = Json::parse(tree.dump(2));
  EXPECT_EQ(read, tree);
  EXPECT_EQ(read["largest"].get<std::uint64_t>(), std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(read["least"].get<std::int64_t>(), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(read["float"].get<float>(), 0.1F);
  EXPECT_EQ(Json::parse(R"({"a":1,"b":2,"a":3})").dump(), R"({"a":3,"b":2})") << "the last of two values is read";
  EXPECT_NE(Json::parse(R"({"a":1,"b":2})"), Json::parse(R"({"b":2,"a":1})"));
  EXPECT_EQ(Json(1), Json(1.0));
  EXPECT_GT(read["third"], 0.3);
}

// Catches a file from outside that overflows the stack, or that takes minutes because each name is compared with all.
TEST(Json, RefusesWhatIsNoJsonOrTooLarge) {
  const auto object = [](int names) {
    std::string text = "{\"n,[\": 0";
    for (int i = 1; i < names; ++i) {
      text += ", \"" + std::to_string(i) + "\": [1, 2]";
    }
    return text + "}";
  };
  EXPECT_TRUE(Json::parse(std::string(64, '[') + std::string(64, ']')).is_array());
  EXPECT_TRUE(Json::parse(std::string(65, '[') + std::string(65, ']')).is_null());
  EXPECT_EQ(Json::parse(object(10000)).size(), 10000U);
  EXPECT_TRUE(Json::parse(object(10001)).is_null());
  EXPECT_EQ(Json::parse(Json(std::vector<int>(20000)).dump()).size(), 20000U) << "a list may be long";
  for (const char* const wrong : {"", "{", "{\"a\": nan}", "\"\xff\"", "[1,]", "\"open", "1e999"}) {
    EXPECT_TRUE(Json::parse(wrong).is_null()) << wrong;
  }
}

// Catches a message that does not say what is wrong with a file.
TEST(Json, SaysWhatCannotBeRead) {
  const auto refusal = [](const auto& read) { return host_tests::refusal_by<JsonError>(read); };
  const Json tree = Json::parse(R"({"word": "a", "list": [1], "flag": true, "null": null, "large": 1e300})");
  EXPECT_EQ(refusal([&] { tree.at("other"); }), "key 'other' not found");
  EXPECT_EQ(refusal([&] { tree["list"]["a"]; }), "cannot use at() with array");
  EXPECT_EQ(refusal([&] { tree["list"][1]; }), "array index 1 is out of range");
  EXPECT_EQ(refusal([&] { tree["word"].get<double>(); }), "type must be number, but is string");
  EXPECT_EQ(refusal([&] { tree["list"].get<bool>(); }), "type must be boolean, but is array");
  EXPECT_EQ(refusal([&] { tree["flag"].get<std::string>(); }), "type must be string, but is boolean");
  EXPECT_EQ(refusal([&] { tree["null"].get<std::vector<int>>(); }), "type must be array, but is null");
  EXPECT_EQ(refusal([&] { tree["large"].get<int>(); }), "number is out of range");
  EXPECT_EQ(refusal([&] { tree["list"].value("a", 1); }), "cannot use value() with array");
  EXPECT_EQ(refusal([&] { tree["flag"].items(); }), "cannot use items() with boolean");
  EXPECT_EQ(refusal([&] { Json(tree["word"]).push_back(1); }), "cannot use push_back() with string");
  EXPECT_EQ(refusal([&] { Json(tree).update(1); }), "cannot use update() with number");
  EXPECT_EQ(tree.value("other", 7) + tree["list"].get<std::vector<int>>().front(), 8);
}

}  // namespace
}  // namespace m100
