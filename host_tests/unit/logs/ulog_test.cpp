// SPDX-License-Identifier: BSD-3-Clause
#include <cstdint>
#include <cstring>

#include "host_tests/tools/logs/raw_log.h"
#include "host_tests/unit/logs/log_files.h"

namespace m100::tools::logs {
namespace {

/// Writes ULog by hand, from the published format: an independent second reading of it.
class UlogBytes {
 public:
  UlogBytes() { bytes_ = std::string("ULog\x01\x12\x35\x01", 8) + std::string(8, '\0'); }

  void message(char type, const std::string& payload) {
    bytes_ += raw(static_cast<std::uint16_t>(payload.size())) + type + payload;
  }
  void subscribe(std::uint8_t instance, std::uint16_t id, const std::string& name) {
    message('A', raw(instance) + raw(id) + name);
  }

  template <typename T>
  static std::string raw(T value) {
    std::string bytes(sizeof value, '\0');
    std::memcpy(bytes.data(), &value, sizeof value);
    return bytes;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

UlogBytes sticks() {
  UlogBytes log;
  log.message('B', std::string(40, '\0'));
  log.message('F', "point:float x;float y;");
  log.message('F', "sticks:uint64_t timestamp;point place;uint16_t[2] axes;uint8_t[4] _padding0;");
  log.subscribe(0, 7, "sticks");
  log.subscribe(1, 8, "sticks");
  for (std::uint64_t k = 0; k < 3; ++k) {
    for (const std::uint16_t id : {std::uint16_t{7}, std::uint16_t{8}}) {
      log.message('D', UlogBytes::raw(id) + UlogBytes::raw(std::uint64_t{1000000} * (k + 1)) +
                           UlogBytes::raw(0.5F * static_cast<float>(k)) + UlogBytes::raw(-1.F) + UlogBytes::raw(id) +
                           UlogBytes::raw(static_cast<std::uint16_t>(1024 + k)) + std::string(4, '\0'));
    }
  }
  return log;
}

TEST(Ulog, ReadsNestedFieldsArraysAndInstances) {
  const TemporaryFile file("a.ulg", sticks().bytes());
  const auto log = open_log(file.path());
  EXPECT_EQ(log->column("sticks.timestamp", "time").values, (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(log->column("sticks.place.x", "x").values, (std::vector<double>{0, 0.5, 1}));
  EXPECT_EQ(log->column("sticks.axes[1]", "x").values, (std::vector<double>{1024, 1025, 1026}));
  const RawColumn second = log->column("sticks#1.axes[0]", "x");
  EXPECT_EQ(second.values, (std::vector<double>{8, 8, 8}));
  EXPECT_EQ(second.time_s, (std::vector<double>{1, 2, 3}));
}

TEST(Ulog, KeepsWhatCameBeforeTheLossOfPower) {
  const std::string bytes = sticks().bytes();
  const TemporaryFile file("a.ulg", bytes.substr(0, bytes.size() - 5));
  EXPECT_EQ(open_log(file.path())->column("sticks#1.place.x", "x").values.size(), 2U);
}

TEST(Ulog, RefusesUnknownColumnsAndForeignData) {
  const TemporaryFile file("a.ulg", sticks().bytes());
  EXPECT_NE(complaint_of([&] { open_log(file.path())->column("sticks.place.z", "rate_x"); }).find("sticks.place.x"),
            std::string::npos);
  UlogBytes log = sticks();
  log.message('D', UlogBytes::raw(std::uint16_t{99}) + std::string(24, '\0'));
  const TemporaryFile foreign("b.ulg", log.bytes());
  EXPECT_NE(complaint_of([&] { open_log(foreign.path()); }).find("was not announced"), std::string::npos);
}

}  // namespace
}  // namespace m100::tools::logs
