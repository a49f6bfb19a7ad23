// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/lab/logs/raw_log.h"
#include "host_tests/lab/logs/write_csv.h"
#include "host_tests/unit/logs/log_files.h"

namespace m100::lab::logs {
namespace {

TEST(Csv, ReadsQuotesCrLfByteOrderMarkAndBlankLines) {
  const std::string file = host_tests::made("a.csv", "\xEF\xBB\xBF\"t, s\",x\r\n0,+1\r\n\r\n\"0.5\",-2e1\r\n");
  const auto log = open_log(file);
  EXPECT_EQ(log->names(), (std::vector<std::string>{"t, s", "x"}));
  EXPECT_EQ(log->column("t, s", "time").values, (std::vector<double>{0, 0.5}));
  EXPECT_EQ(log->column("x", "rate_x").values, (std::vector<double>{1, -20}));
}

TEST(Csv, TakesSemicolonsAndTabs) {
  const std::string semicolons = host_tests::made("a.csv", "t;x\n0;1\n1;2\n");
  EXPECT_EQ(open_log(semicolons)->column("x", "rate_x").values, (std::vector<double>{1, 2}));
  const std::string tabs = host_tests::made("b.csv", "t\tx\n0\t1\n1\t2\n");
  EXPECT_EQ(open_log(tabs)->column("x", "rate_x").values, (std::vector<double>{1, 2}));
}

// A text column, or a column with empty cells, does not matter unless it is asked for.
TEST(Csv, LooksOnlyAtColumnsThatAreAskedFor) {
  const std::string file = host_tests::made("a.csv", "t,mode,x\n0,F,1\n1,,2\n");
  EXPECT_EQ(open_log(file)->column("x", "rate_x").values, (std::vector<double>{1, 2}));
}

struct BadCsv {
  const char* name;
  const char* text;
  const char* says;
};

class BadCsvFile : public ::testing::TestWithParam<BadCsv> {};

TEST_P(BadCsvFile, IsRefusedWithItsPlace) {
  const std::string file = host_tests::made("x.csv", GetParam().text);
  const std::string said = complaint_of([&] { open_log(file)->column("x", "rate_x"); });
  EXPECT_EQ(said.rfind(file + GetParam().says, 0), 0U) << said;
}

INSTANTIATE_TEST_SUITE_P(
    Table, BadCsvFile,
    ::testing::Values(BadCsv{"Empty", "", ": is empty"}, BadCsv{"OnlyBlankLines", "\n\r\n", ": is empty"},
                      BadCsv{"NoSamples", "t,x\n", ":1: has a header but no samples"},
                      BadCsv{"NoSuchColumn", "t,y\n0,1\n", ":1: 'x': no such column (wanted for rate_x); there are: "},
                      BadCsv{"Nan", "t,x\n0,1\n1,nan\n", ":3: 'x': 'nan' is not a finite number"},
                      BadCsv{"Infinite", "t,x\n0,inf\n", ":2: 'x': 'inf' is not a finite number"},
                      BadCsv{"Hole", "t,x\n0,\n", ":2: 'x': '' is not a finite number"},
                      BadCsv{"Text", "t,x\n0,1.5m\n", ":2: 'x': '1.5m' is not a finite number"},
                      BadCsv{"ShortRow", "t,x\n0,1\n2\n", ":3: 'x': the row has 1 cells, the header 2"},
                      BadCsv{"LongRow", "t,x\n0,1,2\n", ":2: 'x': the row has 3 cells, the header 2"},
                      BadCsv{"OpenQuote", "t,x\n0,\"1\n", ":2: 'x': a quote is left open"},
                      BadCsv{"TwiceTheSameName", "x,x\n0,1\n", ":1: 'x': the column appears twice"}),
    [](const auto& tested) { return tested.param.name; });

TEST(OpenLog, NamesAFileThatIsNotThere) {
  EXPECT_EQ(complaint_of([] { open_log("/nowhere/a.csv"); }), "/nowhere/a.csv: cannot be read");
}

TEST(OpenLog, RefusesADamagedMatFile) {
  const std::string file = host_tests::made("a.mat", "MATLAB 5.0 MAT-file, cut short");
  EXPECT_EQ(complaint_of([&] { open_log(file); }).rfind(file + ": ", 0), 0U);
}

// Catches a short row after which the list of topics loses the clock of all following rows.
TEST(Csv, OneSpoiltRowDoesNotSpoilTheClockOfTheTopics) {
  const std::string file = host_tests::made("a.csv", "t,x\n0,1\n0.1\n0.2,2\n0.3,3\n");
  EXPECT_NEAR(open_log(file)->topics().at(0).to_s, 0.3, 1e-12);
}

// A stream slower than its file has empty cells in most rows; that does not make it a text column.
TEST(Csv, EmptyCellsAreNotSampled) {
  const std::string file = host_tests::made("a.csv", "t,x\n0,1\n1,\n2,\n3,\n4,5\n");
  const std::vector<double> x = open_log(file)->column("x", "rate_x").values;
  ASSERT_EQ(x.size(), 5U);
  EXPECT_EQ(x[0], 1.0);
  EXPECT_TRUE(std::isnan(x[2]));
}

FlightLog with_gaps() {
  FlightLog log;
  log.start_s = 1.7e9 + 0.25;  // seconds since 1970
  log.size = 500;
  log.gap.assign(log.size, 0);
  for (const Signal signal : {Signal::kStickRoll, Signal::kAttitudeRoll}) {
    log.of(signal).resize(log.size);
    for (std::size_t k = 0; k < log.size; ++k) {
      log.of(signal)[k] = std::sin(0.05 * static_cast<double>(k));
    }
  }
  std::vector<std::uint8_t>& gap = log.signal_gap[Signal::kAttitudeRoll];
  gap.assign(log.size, 0);
  for (std::size_t k = 100; k < 400; ++k) {
    gap[k] = log.gap[k] = 1;
  }
  return log;
}

// Catches a converted log in which a gap has become data, or in which samples share a time stamp.
TEST(WriteCsv, KeepsGapsAndClocks) {
  const FlightLog log = with_gaps();
  const std::string csv = host_tests::made("a.csv", "");
  const std::string map = host_tests::made("a.toml", "");
  write_csv(log, csv);
  write_column_map(log, map);
  const FlightLog back = load(csv, map);
  EXPECT_NEAR(back.start_s, log.start_s, 1e-5);
  ASSERT_EQ(back.size, log.size);
  const std::vector<std::uint8_t> gap = back.gap_of({Signal::kAttitudeRoll});
  const std::vector<std::uint8_t> stick = back.gap_of({Signal::kStickRoll});
  for (std::size_t k = 0; k < log.size; ++k) {
    EXPECT_EQ(gap[k], log.gap[k]) << k;
    EXPECT_EQ(stick[k], 0) << k;
    EXPECT_NEAR(back.of(Signal::kStickRoll)[k], log.of(Signal::kStickRoll)[k], 1e-6) << k;
  }
}

}  // namespace
}  // namespace m100::lab::logs
