// SPDX-License-Identifier: BSD-3-Clause
// Campaigns over worlds, tasks and seeds; splitting and merging must not change the result.
#include "host_tests/lab/campaign/campaign.h"
#include "firmware/companion/files/text/json.h"

#include <gtest/gtest.h>
#include <fstream>

#include "firmware/companion/files/recorded_flight.h"
#include "firmware/companion/replay/replay.h"
#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/campaign/page.h"
#include "host_tests/lab/campaign/report_json.h"
#include "host_tests/lab/input_error.h"

namespace m100::lab::campaign {
namespace {

/// Two worlds; in the second one no flight is possible, because no pose arrives.
Campaign small() {
  Campaign campaign;
  campaign.worlds.push_back(
      {.name = "kind", .path = "a b/nominal.toml", .digest = "1", .plant = sim::measured_plant()});
  campaign.worlds.push_back({.name = "blind", .path = "blind.toml", .digest = "2", .plant = sim::measured_plant()});
  campaign.worlds[1].plant.pose.dropout_per_s = 100.0;
  campaign.tasks = tasks_of("hover,step_1m");
  campaign.first_seed = 7;
  campaign.flights = 2;
  campaign.settings.plan.vehicle = companion::as_file(mpc::generated::kVehicle);
  campaign.options = {"--channel", "movement"};
  return campaign;
}

std::string text_of(const Campaign& campaign, const Share& share, std::size_t jobs) {
  return to_json(campaign, share, fly(campaign, share, jobs, {})).dump(1);
}

/// The campaign of all tests of this file, flown once.
const std::string& whole() {
  static const std::string kText = text_of(small(), {}, 1);
  return kText;
}

std::string saved(const std::string& name, const std::string& text) {
  std::string path = ::testing::TempDir() + "campaign_" + name + ".json";
  std::ofstream(path) << text;
  return path;
}

TEST(Campaign, CountsWhatStaysAndSaysHowToRepeatWhatDoesNot) {
  const auto report = Json::parse(whole());
  const auto& kind = report.at("worlds").at("kind");
  EXPECT_EQ(kind.at("flights"), 4);
  EXPECT_EQ(kind.at("stayed"), 4);
  EXPECT_EQ(kind.at("released"), 0);
  EXPECT_EQ(kind.at("fence_breaches"), 0);
  EXPECT_EQ(kind.at("oscillating"), 0);
  EXPECT_EQ(kind.at("tasks").at("step_1m").at("flights"), 2);
  EXPECT_LT(kind.at("tasks").at("hover").at("pose_rms_m").at("max").get<double>(), 0.052);  // the paper's hover
  EXPECT_TRUE(kind.at("failures").empty());
  // The observer's covariance matches its errors: NEES of 0.2 to 2 in calm air; the ideal value is 1.
  EXPECT_GT(kind.at("nees").get<double>(), 0.2);
  EXPECT_LT(kind.at("nees").get<double>(), 2.0);
  EXPECT_GT(kind.at("nis").get<double>(), 0.0);
  EXPECT_LT(kind.at("nis").get<double>(), 2.0);

  const auto& blind = report.at("worlds").at("blind");
  EXPECT_EQ(blind.at("stayed"), 0);
  ASSERT_EQ(blind.at("failures").size(), 4U);
  EXPECT_TRUE(blind.at("pose_rms_m").at("median").is_null())
      << "a flight that never began must have no error, not an error of zero";
  EXPECT_TRUE(blind.at("tasks").at("hover").at("tilt_rms_deg").is_null());
  const auto& first = blind.at("failures").at(0);
  EXPECT_EQ(first.at("task"), "hover");
  EXPECT_EQ(first.at("seed"), 7);
  EXPECT_EQ(first.at("why").get<std::string>().substr(0, 11), "never flew:");
  EXPECT_EQ(first.at("command"), "m100-lab campaign blind.toml --tasks hover --flights 1 --seed 7 --channel movement");
}

// A command that repeats one flight must give the same flight, whatever seeds were flown before.
TEST(Campaign, RepeatsASingleFlightAsItWas) {
  Campaign one = small();
  one.worlds.resize(1);
  one.tasks = tasks_of("step_1m");
  one.first_seed = 8;
  one.flights = 1;
  auto again = Json::parse(text_of(one, {}, 1)).at("flown").at(0);
  auto before = Json::parse(whole()).at("flown").at(3);
  again.erase("number");
  before.erase("number");
  EXPECT_EQ(again, before);
}

TEST(Campaign, IsTheSameOnSoManyThreads) { EXPECT_EQ(text_of(small(), {}, 3), whole()); }

TEST(Campaign, JoinedFromItsPartsIsByteForByteTheWhole) {
  std::vector<std::string> parts;
  for (std::size_t part = 1; part <= 3; ++part) {
    parts.push_back(saved(std::to_string(part), text_of(small(), {.part = part, .parts = 3}, 2)));
  }
  EXPECT_EQ(merged(parts).dump(1), whole());
  EXPECT_EQ(merged({parts[2], parts[0], parts[1]}).dump(1), whole());
  EXPECT_EQ(merged({saved("whole", whole())}).dump(1), whole());

  EXPECT_THROW(merged({parts[0], parts[1]}), InputError);            // one is missing
  EXPECT_THROW(merged({parts[0], parts[1], parts[1]}), InputError);  // one is there twice
  EXPECT_THROW(merged({saved("other", "{\"worlds\": {}}")}), InputError);
  Campaign other = small();
  other.worlds[0].digest = "3";
  other.worlds[0].plant.pose.dropout_per_s = 100.0;
  const std::string foreign = saved("foreign", text_of(other, {.part = 3, .parts = 3}, 1));
  EXPECT_THROW(merged({parts[0], parts[1], foreign}), InputError);
}

TEST(Campaign, WritesATableAndAPageWithHeatMaps) {
  const auto report = Json::parse(whole());
  std::ostringstream table;
  print_table(table, report);
  EXPECT_NE(table.str().find("4 of 8 flights stayed"), std::string::npos) << table.str();
  EXPECT_NE(table.str().find("--seed 8"), std::string::npos);
  const std::string folder = ::testing::TempDir() + "campaign_page";
  write_page(folder, report, {{"kind, hover, seed 1", "flight_kind_hover_1.html"}});
  std::ifstream file(folder + "/campaign.html");
  const std::string page(std::istreambuf_iterator<char>(file), {});
  EXPECT_NE(page.find("class=\"heat"), std::string::npos);
  EXPECT_NE(page.find("0 of 2"), std::string::npos);
  EXPECT_NE(page.find("<a href=\"flight_kind_hover_1.html\">kind, hover, seed 1</a>"), std::string::npos);
}

// The pilot's drift until control is taken moves the course's start, which the log notes before the flight.
TEST(Campaign, TheLogOfAWorstFlightReplaysToTheSameBits) {
  const Campaign campaign = small();
  std::string bytes = log_of(campaign.worlds[0].plant, campaign.tasks[1], 7, campaign.settings);
  const companion::RecordedFlight flight = companion::parse_flight_log(std::move(bytes), "worst");
  const companion::ReplayResult result = companion::replay(flight, companion::Scalar::kDouble, nullptr);
  EXPECT_GT(result.ticks, 100U);
  EXPECT_EQ(result.different_ticks, 0U);
}

// The tables of a tuned file with a long delay had 130 000 bytes, two notes of a log hold 120 000, and fly refused.
TEST(LogNotes, HoldGainTablesOfAnySizeThatOccurs) {
  for (const std::size_t size : {1U, 60000U, 60001U, 130000U, 300000U}) {
    std::string tables(size, 'a');
    tables.back() = 'z';
    std::vector<log::Note> notes;
    ASSERT_TRUE(companion::add_table_notes(tables, notes)) << size;
    companion::RecordedFlight flight;
    for (const log::Note& note : notes) {
      EXPECT_LE(note.text.size(), log::kLongestNote_bytes);
      flight.notes.emplace(note.key, note.text);
    }
    EXPECT_EQ(companion::tables_of(flight), tables);
  }
  std::vector<log::Note> notes;
  EXPECT_FALSE(companion::add_table_notes(std::string(300001, 'a'), notes));
}

}  // namespace
}  // namespace m100::lab::campaign
