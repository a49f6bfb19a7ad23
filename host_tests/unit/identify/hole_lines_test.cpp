// SPDX-License-Identifier: BSD-3-Clause
// What is said of a hole, of a clock that counts from 1970, and of a parameter in the unit of its input.
#include <gtest/gtest.h>

#include "host_tests/lab/identify/data/log_ranges.h"
#include "host_tests/lab/identify/output/result_text.h"
#include "host_tests/lab/logs/join.h"

namespace m100::lab::identify {
namespace {

using logs::FlightLog;
using logs::Signal;

FlightLog log_of_a_minute() {
  FlightLog log;
  log.size = 6000;
  log.gap.assign(log.size, 0);
  return log;
}

void lose(FlightLog& log, Signal signal, std::size_t from, std::size_t to) {
  log.of(signal).assign(log.size, 0.0);
  std::vector<std::uint8_t>& missing = log.signal_gap[signal];
  missing.resize(log.size, 0);
  std::fill(missing.begin() + static_cast<std::ptrdiff_t>(from), missing.begin() + static_cast<std::ptrdiff_t>(to), 1);
}

TEST(HoleLines, OneHoleInManySignalsIsOneLine) {
  FlightLog log = log_of_a_minute();
  for (const Signal signal : {Signal::kStickRoll, Signal::kStickPitch, Signal::kAttitudeRoll, Signal::kRateX}) {
    lose(log, signal, 1000, 1200);
  }
  lose(log, Signal::kVelocityZ, 3000, 3100);
  std::vector<Finding> found;
  find_gaps(log, {{0.0, 59.0}}, found);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NE(found[0].text.find("and 2 more signals are missing or spoilt in 1 place "), std::string::npos)
      << found[0].text;
  EXPECT_NE(found[1].text.find("velocity_z is missing"), std::string::npos) << found[1].text;
}

TEST(EpochClock, IsPrintedRelativeAndRangesCountEitherWay) {
  FlightLog log = log_of_a_minute();
  log.start_s = 1'700'000'000.25;
  logs::count_from_begin(log);
  EXPECT_DOUBLE_EQ(log.start_s, 0.25);
  ASSERT_EQ(log.notes.size(), 1U);
  const std::vector<Range> relative = ranges("--train", "10:20", log);
  const std::vector<Range> absolute = ranges("--train", "1700000010:1700000020", log);
  EXPECT_EQ(relative, absolute);
  FlightLog own = log_of_a_minute();
  own.start_s = 100.0;
  logs::count_from_begin(own);
  EXPECT_DOUBLE_EQ(own.start_s, 100.0);
  EXPECT_TRUE(own.notes.empty());
}

TEST(StickUnit, ACommandsDeadZoneIsNoNumberOfCounts) {
  IdentifyResult result;
  result.axis = "roll";
  result.final_intervals = {{"width_counts", {0.02, 0.01, 0.03}}, {"gain", {1.0, 0.9, 1.1}}};
  EXPECT_NE(to_text(result).find("width_counts"), std::string::npos);
  result.stick_unit = "rad";
  EXPECT_NE(to_text(result).find("width_rad"), std::string::npos);
  EXPECT_EQ(to_text(result).find("counts"), std::string::npos);
}

}  // namespace
}  // namespace m100::lab::identify
