// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstdint>

#include "host_tests/lab/logs/raw_log.h"
#include "host_tests/shared_files.h"
#include "host_tests/unit/logs/log_files.h"
#include "host_tests/unit/logs/ulog_bytes.h"

namespace m100::lab::logs {
namespace {

constexpr const char* kSticks = "sticks:uint64_t timestamp;point place;uint16_t[2] axes;uint8_t[4] _padding0;";

std::string stick_sample(std::uint64_t k, std::uint16_t id, std::size_t padding) {
  return UlogBytes::raw(std::uint64_t{1000000} * (k + 1)) + UlogBytes::raw(0.5F * static_cast<float>(k)) +
         UlogBytes::raw(-1.F) + UlogBytes::raw(id) + UlogBytes::raw(static_cast<std::uint16_t>(1024 + k)) +
         std::string(padding, '\0');
}

UlogBytes sticks(std::size_t padding = 4) {
  UlogBytes log;
  log.message('B', std::string(40, '\0'));
  log.message('F', "point:float x;float y;");
  log.message('F', kSticks);
  log.subscribe(0, 7, "sticks");
  log.subscribe(1, 8, "sticks");
  for (std::uint64_t k = 0; k < 3; ++k) {
    for (const std::uint16_t id : {std::uint16_t{7}, std::uint16_t{8}}) {
      log.data(id, stick_sample(k, id, padding));
    }
  }
  return log;
}

TEST(Ulog, ReadsNestedFieldsArraysAndInstances) {
  const std::string file = host_tests::made("a.ulg", sticks().bytes());
  const auto log = open_log(file);
  EXPECT_EQ(log->column("sticks.timestamp", "time").values, (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(log->column("sticks.place.x", "x").values, (std::vector<double>{0, 0.5, 1}));
  EXPECT_EQ(log->column("sticks.axes[1]", "x").values, (std::vector<double>{1024, 1025, 1026}));
  for (const char* const name : {"sticks:1.axes[0]", "sticks#1.axes[0]"}) {
    const RawColumn second = log->column(name, "x");
    EXPECT_EQ(second.values, (std::vector<double>{8, 8, 8})) << name;
    EXPECT_EQ(second.time_s, (std::vector<double>{1, 2, 3})) << name;
  }
  EXPECT_EQ(log->names().size(), 10U) << "two instances of five numbers, and no padding";
}

// PX4 omits the trailing padding on 50 of 65 topics; a reader that requires it refuses every PX4 log.
TEST(Ulog, ReadsMessagesWithoutTheirTrailingPadding) {
  const std::string file = host_tests::made("a.ulg", sticks(0).bytes());
  EXPECT_EQ(open_log(file)->column("sticks.axes[1]", "x").values, (std::vector<double>{1024, 1025, 1026}));
}

TEST(Ulog, KeepsWhatCameBeforeTheLossOfPower) {
  const std::string bytes = sticks().bytes();
  const std::string file = host_tests::made("a.ulg", bytes.substr(0, bytes.size() - 5));
  EXPECT_EQ(open_log(file)->column("sticks:1.place.x", "x").values.size(), 2U);
}

// The logger lost power in the middle of a message. The data appended later begin where the flags say, not where the
// broken message claims to end.
TEST(Ulog, ReadsAppendedDataBehindABrokenMessage) {
  UlogBytes log;
  log.message('B', std::string(40, '\0'));
  const std::string flagged_body = sticks().bytes().substr(16 + 3 + 40);
  log.append(flagged_body);
  log.append(UlogBytes::raw(std::uint16_t{500}) + "D\x07");  // announces 500 bytes, has one
  const auto offset = static_cast<std::uint64_t>(log.bytes().size());
  log.data(7, stick_sample(3, 7, 0));
  std::string& bytes = log.bytes();
  bytes[16 + 3 + 8] = 1;  // incompatible flag 0: data appended
  bytes.replace(16 + 3 + 16, 8, UlogBytes::raw(offset));
  const std::string file = host_tests::made("a.ulg", bytes);
  EXPECT_EQ(open_log(file)->column("sticks.axes[1]", "x").values, (std::vector<double>{1024, 1025, 1026, 1027}));
  bytes[16 + 3 + 8] = 3;  // also an undefined flag
  const std::string unknown = host_tests::made("b.ulg", bytes);
  EXPECT_NE(complaint_of([&] { open_log(unknown); }).find("unknown features"), std::string::npos);
}

TEST(Ulog, FindsItsWayBackAfterDamage) {
  UlogBytes log = sticks();
  log.append(std::string(37, '\xEE'));
  log.message('S', std::string("\x2f\x73\x13\x20\x25\x0c\xbb\x12", 8));
  log.data(7, stick_sample(3, 7, 4));
  const std::string file = host_tests::made("a.ulg", log.bytes());
  const auto read = open_log(file);
  EXPECT_EQ(read->column("sticks.axes[1]", "x").values.back(), 1027.0);
  ASSERT_EQ(read->notes().size(), 1U);
  EXPECT_EQ(read->notes().front().rfind("37 bytes", 0), 0U) << read->notes().front();
}

TEST(Ulog, RefusesUnknownColumnsAndCountsForeignData) {
  UlogBytes log = sticks();
  log.data(99, std::string(24, '\0'));
  const std::string file = host_tests::made("a.ulg", log.bytes());
  const auto read = open_log(file);
  EXPECT_NE(complaint_of([&] { read->column("sticks.place.z", "rate_x"); }).find("sticks.place.x"), std::string::npos);
  ASSERT_EQ(read->notes().size(), 1U);
  EXPECT_NE(read->notes().front().find("never announced"), std::string::npos);
}

struct Hostile {
  const char* name;
  std::vector<std::string> formats;
};
class HostileUlog : public ::testing::TestWithParam<Hostile> {};

std::vector<std::string> chain(int depth) {
  std::vector<std::string> out{"leaf:float x;"};
  std::string below = "leaf";
  for (int k = 0; k < depth; ++k) {
    const std::string name = std::string(1, 'n').append(std::to_string(k));
    out.push_back(std::string(name).append(":").append(below).append(" a;"));
    below = name;
  }
  out.push_back(std::string("bad:uint64_t timestamp;").append(below).append(" a;"));
  return out;
}
std::vector<std::string> wide() {
  std::vector<std::string> out{"empty:"};
  std::string before = "empty";
  for (int level = 0; level < 8; ++level) {
    const std::string name = std::string("w").append(std::to_string(level));
    std::string text = name + ":";
    for (int k = 0; k < 1000; ++k) {
      text += before + " a" + std::to_string(k) + ";";
    }
    before = name;
    out.push_back(text);
  }
  out.push_back("bad:uint64_t timestamp;w7 a;");
  return out;
}

// Each of these once used all of the memory or more than 12 s of processor time. The intact topic beside it must still
// be read.
TEST_P(HostileUlog, FormatsCostNoMoreThanTheirText) {
  UlogBytes log = sticks();
  for (const std::string& format : GetParam().formats) {
    log.message('F', format);
  }
  log.subscribe(0, 9, "bad");
  log.data(9, std::string(64, '\0'));
  const std::string file = host_tests::made("a.ulg", log.bytes());
  const auto read = open_log(file);
  EXPECT_EQ(read->column("sticks.axes[1]", "x").values.size(), 3U);
  EXPECT_LE(read->names().size(), RawLog::kMaxNames);
  EXPECT_EQ(read->topics().size(), 3U);
  complaint_of([&] { read->column("bad.a", "x"); });
}

INSTANTIATE_TEST_SUITE_P(Table, HostileUlog,
                         ::testing::Values(Hostile{"HugeArray", {"bad:uint64_t timestamp;float[4000000000] a;"}},
                                           Hostile{"NegativeArray", {"bad:uint64_t timestamp;float[-1] a;"}},
                                           Hostile{"ArrayOfAnEmptyType",
                                                   {"empty:", "bad:uint64_t timestamp;empty[4000000000] a;"}},
                                           Hostile{"InsideOfItself", {"bad:uint64_t timestamp;bad[9] a;"}},
                                           Hostile{"ThousandDeep", chain(1000)}, Hostile{"ThousandWide", wide()},
                                           Hostile{"NoClosingBracket", {"bad:uint64_t timestamp;float[3 a;"}}),
                         [](const auto& tested) { return tested.param.name; });

// Once, five of five real PX4 logs were refused.
class Px4File : public ::testing::TestWithParam<const char*> {};

TEST_P(Px4File, Opens) {
  M100_SHARED_FILE_OR_SKIP(path, std::string("data/px4/") + GetParam());
  const auto log = open_log(path.string());
  const RawColumn w = log->column("vehicle_attitude.q[0]", "attitude_qw");
  const RawColumn x = log->column("vehicle_attitude.q[1]", "attitude_qx");
  const RawColumn y = log->column("vehicle_attitude.q[2]", "attitude_qy");
  const RawColumn z = log->column("vehicle_attitude.q[3]", "attitude_qz");
  ASSERT_GT(w.values.size(), 50U);
  for (std::size_t k = 0; k < w.values.size(); ++k) {
    const double size = std::hypot(std::hypot(w.values[k], x.values[k]), std::hypot(y.values[k], z.values[k]));
    EXPECT_NEAR(size, 1.0, 1e-5) << k;  // single precision; a wrong field offset would not give unit length
  }
  for (std::size_t k = 1; k < w.time_s.size(); ++k) {
    EXPECT_GT(w.time_s[k], w.time_s[k - 1]);
  }
}

INSTANTIATE_TEST_SUITE_P(Shared, Px4File,
                         ::testing::Values("sample.ulg", "sample_log_small.ulg", "sample_appended_multiple.ulg"),
                         [](const auto& tested) {
                           const std::string name(tested.param);
                           return name.substr(0, name.find('.'));
                         });

}  // namespace
}  // namespace m100::lab::logs
