// SPDX-License-Identifier: BSD-3-Clause
// Every kind of bad input to `m100-lab identify` ends in a one-line message with the file, line and key.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "host_tests/lab/subcommands.h"
#include "host_tests/unit/lab/refusal.h"

namespace m100::lab {
namespace {

constexpr const char* kMap = R"(time = "t_s"
[signals]
stick_roll = { column = "rc_roll", offset = -1024 }
attitude_roll = "roll"
)";

/// Forty seconds in which the stick moves and the roll follows.
std::string flight(const std::string& names, double stick_size) {
  std::string text = names + "\n";
  double roll = 0.0;
  for (int row = 0; row < 4000; ++row) {
    const double stick = stick_size * std::sin(0.02 * row) * std::cos(0.0031 * row);
    roll += 0.05 * (9e-4 * stick - roll);
    text += std::to_string(0.01 * row) + "," + std::to_string(1024.0 + stick) + "," + std::to_string(roll) + "\n";
  }
  return text;
}

/// The same time stamps, with a word in the roll column.
std::string words() {
  std::string text = "t_s,rc_roll,roll\n";
  for (int row = 0; row < 4000; ++row) {
    text += std::to_string(0.01 * row) + ",1024,level\n";
  }
  return text;
}

struct Case {
  std::string name;
  std::string log;
  std::string map;
  std::vector<std::string> options;
  std::vector<std::string> must_say;
};

class BadInput : public ::testing::TestWithParam<Case> {
 protected:
  std::string write(const std::string& name, const std::string& text) const {
    const std::filesystem::path path = std::filesystem::temp_directory_path() / name;
    std::ofstream(path) << text;
    return path.string();
  }
};

TEST_P(BadInput, IsOneClearLine) {
  std::vector<std::string> words{"identify", "--log", write("flight.csv", GetParam().log), "--columns",
                                 write("map.toml", GetParam().map)};
  words.insert(words.end(), GetParam().options.begin(), GetParam().options.end());
  const std::string said = refusal_of(add_identify, words);
  ASSERT_FALSE(said.empty()) << "nothing was thrown";
  EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  for (const std::string& part : GetParam().must_say) {
    EXPECT_NE(said.find(part), std::string::npos) << "'" << part << "' is not in: " << said;
  }
}

std::vector<std::string> ask(const std::string& axis, const std::string& declare, const std::string& train,
                             const std::string& validate) {
  return {"--axis", axis, "--declare", declare, "--train", train, "--validate", validate};
}

const std::string kGood = flight("t_s,rc_roll,roll", 200.0);
const std::vector<std::string> kAsked = ask("roll", "first_order", "2:25", "25:39");

INSTANTIATE_TEST_SUITE_P(
    Table, BadInput,
    ::testing::Values(
        Case{"MissingColumn", flight("t_s,rc_roll,phi", 200.0), kMap, kAsked, {"flight.csv", "roll"}},
        Case{"TextInThePlaceOfNumbers", words(), kMap, kAsked, {"flight.csv:2", "roll", "level"}},
        Case{"EmptyFile", "", kMap, kAsked, {"flight.csv", "empty"}},
        Case{"StickNeverMoved",
             flight("t_s,rc_roll,roll", 0.0),
             kMap,
             kAsked,
             {"flight.csv", "stick_roll", "never moved"}},
        Case{"SignalNotInTheMap", kGood, kMap, ask("pitch", "first_order", "2:25", "25:39"), {"stick_pitch"}},
        Case{"UnknownKeyInTheMap",
             kGood,
             std::string(kMap) + "stick_foo = \"rc_roll\"\n",
             kAsked,
             {"map.toml:5", "stick_foo"}},
        Case{"RangeOutsideOfTheLog", kGood, kMap, ask("roll", "first_order", "2:25", "25:99"), {"--validate 25:99"}},
        Case{"RangeBackwards", kGood, kMap, ask("roll", "first_order", "25:2", "25:39"), {"--train", "25:2"}},
        Case{"RangeNotANumber", kGood, kMap, ask("roll", "first_order", "2:x", "25:39"), {"--train", "x"}},
        Case{"RangesOverlap", kGood, kMap, ask("roll", "first_order", "2:27", "25:39"), {"overlaps"}},
        Case{"TrainingTooShort", kGood, kMap, ask("roll", "first_order", "2:6", "25:39"), {"--train", "blocks"}},
        Case{"UnknownEffect", kGood, kMap, ask("roll", "second_order,magic", "2:25", "25:39"), {"--declare", "magic"}},
        Case{"DeclaredTwice",
             kGood,
             kMap,
             ask("roll", "second_order,dead_zone,dead_zone", "2:25", "25:39"),
             {"--declare", "dead_zone", "twice"}},
        Case{"NoBaseModel", kGood, kMap, ask("roll", "dead_zone", "2:25", "25:39"), {"--declare", "first_order"}},
        Case{"UnknownAxis", kGood, kMap, ask("yaw", "first_order", "2:25", "25:39"), {"--axis", "yaw"}}),
    [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace m100::lab
