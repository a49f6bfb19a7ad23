// SPDX-License-Identifier: BSD-3-Clause
// The kept flights must be flown to the last bit as they were, on every machine. A change of the flight code cannot
// pass unnoticed.
#include "host_tests/golden/flight/kept_flights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

namespace m100::golden {
namespace {

const std::filesystem::path kFolder = "host_tests/golden/flight/kept";

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream text(line);
  return {std::istream_iterator<std::string>(text), {}};
}

/// The lines of the table that belong to one flight.
std::vector<std::string> kept_lines(const std::string& name) {
  std::ifstream file(kFolder / "kept.txt");
  std::vector<std::string> out;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with(name + " ")) {
      out.push_back(line);
    }
  }
  return out;
}

class KeptFlights : public ::testing::TestWithParam<KeptFlight> {};
INSTANTIATE_TEST_SUITE_P(Table, KeptFlights, ::testing::ValuesIn(kKeptFlights),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(KeptFlights, AreFlownToTheLastBitAsTheyWere) {
  RecordProperty("promise", "R6");
  const std::vector<std::string> kept = kept_lines(GetParam().name);
  const std::vector<std::string> flown = lines_of(GetParam(), kFolder);
  ASSERT_EQ(kept.size(), flown.size());
  for (std::size_t i = 0; i < flown.size(); ++i) {
    const std::vector<std::string> was = words_of(kept[i]), is = words_of(flown[i]);
    EXPECT_GT(is.size(), 8U) << "the recording is short";
    const auto differs = std::mismatch(was.begin(), was.end(), is.begin(), is.end()).first;
    EXPECT_TRUE(was == is) << is[1] << ": other from second " << differs - was.begin() - 1
                           << " on. If that is meant, write kept.txt anew, as its beginning says, and say so.";
  }
}

}  // namespace
}  // namespace m100::golden
