// SPDX-License-Identifier: BSD-3-Clause
// Damaged logs of every format must give a log or a one-line error, never a crash, and never the amount of work that a
// damaged number demands. The fuzzer of host_tests/fuzz goes further.
#include <random>

#include "host_tests/lab/logs/proposal/propose.h"
#include "host_tests/lab/logs/raw_log.h"
#include "host_tests/unit/logs/log_files.h"
#include "host_tests/unit/logs/log_samples.h"

namespace m100::lab::logs {
namespace {

/// Calls everything that a user can ask of a file. @returns whether it was a log.
bool ask_everything(const std::string& path) {
  try {
    const auto log = open_log(path);
    static_cast<void>(log->topics());
    static_cast<void>(log->notes());
    static_cast<void>(propose(*log));
    const std::vector<std::string> names = log->names();
    EXPECT_LE(names.size(), RawLog::kMaxNames);
    for (std::size_t k = 0; k < std::min<std::size_t>(names.size(), 12); ++k) {
      try {
        static_cast<void>(log->column(names[k], "a test"));
      } catch (const InputError&) {
      }
    }
    return true;
  } catch (const InputError& refusal) {
    EXPECT_EQ(std::string(refusal.what()).rfind(path, 0), 0U) << "names the file first: " << refusal.what();
    return false;
  }
}

TEST(DamagedLogs, SoundOnesAreRead) {
  for (const auto& [format, bytes] : log_samples("sound")) {
    const std::string file = host_tests::made(format, bytes);
    EXPECT_TRUE(ask_everything(file)) << format;
    EXPECT_FALSE(open_log(file)->names().empty()) << format;
  }
}

TEST(DamagedLogs, EveryTruncationIsSurvived) {
  for (const auto& [format, bytes] : log_samples("cut")) {
    for (std::size_t length = 0; length < bytes.size(); length += 1 + bytes.size() / 50) {
      const std::string file = host_tests::made(format, bytes.substr(0, length));
      SCOPED_TRACE(format + " " + std::to_string(length));
      ask_everything(file);
    }
  }
}

/// Overwrites up to four places with a flipped bit or with a small, large or arbitrary number.
std::string with_damage(std::string bytes, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto place = [&](std::size_t room) { return random() % (bytes.size() - room); };
  for (unsigned k = 0; k <= seed % 4; ++k) {
    if (random() % 3 == 0) {
      const std::uint32_t wild =
          random() % 2 == 0 ? 0xFFFFFFFFU >> (random() % 32) : static_cast<std::uint32_t>(random());
      bytes.replace(place(4), 4, UlogBytes::raw(wild));
    } else {
      char& byte = bytes[place(0)];
      byte = static_cast<char>(static_cast<unsigned char>(byte) ^ (1U << random() % 8));
    }
  }
  return bytes;
}

// Once, 19 of 1400 single bits and 77 of 450 mutants of a MAT-file ended in a segmentation fault (a null field).
TEST(DamagedLogs, FlippedBitsAndWildNumbersAreSurvived) {
  constexpr int kRounds = 120;
  for (const auto& [format, bytes] : log_samples("flip")) {
    for (std::uint32_t seed = 0; seed < kRounds; ++seed) {
      SCOPED_TRACE(format + ", seed " + std::to_string(seed));
      const std::string file = host_tests::made(format, with_damage(bytes, seed));
      ask_everything(file);
    }
  }
}

TEST(DamagedLogs, ManyColumnsCostNoMoreThanTheirBytes) {
  std::string header = "t_s";
  std::string row = "0";
  for (int k = 0; k < 200'000; ++k) {
    header += ",c" + std::to_string(k);
    row += ",1";
  }
  const std::string file = host_tests::made("wide.csv", header + "\n" + row + "\n" + row + "\n");
  const auto log = open_log(file);
  EXPECT_EQ(log->names().size(), 200'001U);
  EXPECT_EQ(log->column("c199999", "x").values.size(), 2U);
  EXPECT_NE(complaint_of([&] { log->column("c200000", "x"); }).find("c20000"), std::string::npos);
}

struct HostileBag {
  const char* name;
  std::string definition;
  std::string message;
};
class HostileBags : public ::testing::TestWithParam<HostileBag> {};

std::string nested_empty_trees() {
  std::string out = "L0 a\n";
  for (int level = 0; level < 8; ++level) {
    out += "===\nMSG: x/L" + std::to_string(level) + "\n";
    for (int k = 0; k < 50; ++k) {
      out.append("L").append(std::to_string(level + 1)).append("[1000] f").append(std::to_string(k)).append("\n");
    }
  }
  return out + "===\nMSG: x/L8\n";
}

// Each of these once took more than 12 s of processor time.
TEST_P(HostileBags, CostNoMoreThanTheirBytes) {
  const std::string bytes =
      "#ROSBAG V2.0\n" +
      bag_record(bag_field("op", "\x07") + bag_field("conn", UlogBytes::raw(0U)) + bag_field("topic", "/a"),
                 bag_field("type", "x/A") + bag_field("message_definition", GetParam().definition)) +
      bag_record(
          bag_field("op", "\x02") + bag_field("conn", UlogBytes::raw(0U)) + bag_field("time", std::string(8, '\1')),
          GetParam().message);
  const std::string file = host_tests::made("a.bag", bytes);
  ask_everything(file);
}

INSTANTIATE_TEST_SUITE_P(
    Table, HostileBags,
    ::testing::Values(HostileBag{"ManyEmpty", "Empty[2000000000] a\n===\nMSG: std_msgs/Empty\n", ""},
                      HostileBag{"CountedEmpty", "Empty[] a\n===\nMSG: std_msgs/Empty\n", "\xff\xff\xff\xff"},
                      HostileBag{"Count", "float64[] a\n", "\xff\xff\xff\xff"},
                      HostileBag{"CountedText", "string[] a\n", "\xff\xff\xff\xff"},
                      HostileBag{"FixedArray", "uint8[4294967295] a\n", "abc"},
                      HostileBag{"NestedEmptyTrees", nested_empty_trees(), ""},
                      HostileBag{"InsideOfItself", "A a\n===\nMSG: x/A\nA a\n", "abc"}),
    [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace m100::lab::logs
