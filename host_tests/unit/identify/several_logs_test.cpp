// SPDX-License-Identifier: BSD-3-Clause
// The command line of `m100-lab identify`: several logs, ranges, spoilt rows inside and outside of ranges.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "firmware/companion/files/text/json.h"
#include "host_tests/lab/logs/write_csv.h"
#include "host_tests/lab/subcommands.h"
#include "host_tests/lab/whole_file.h"
#include "host_tests/property/identify/synthetic_axis.h"
#include "host_tests/unit/lab/refusal.h"

namespace m100::lab {
namespace {

using host_tests::SyntheticAxis;

class SeveralLogs : public ::testing::Test {
 protected:
  SeveralLogs()
      : folder_(std::filesystem::temp_directory_path() /
                (std::string("m100_several_") + ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    std::filesystem::create_directories(folder_);
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// Writes a flight of one vehicle; `spoil` may change each line of its file.
  template <typename Spoil>
  void write(const std::string& name, const SyntheticAxis& vehicle, double start_s, Spoil&& spoil) const {
    logs::FlightLog log = vehicle.fly();
    log.start_s = start_s;
    logs::write_csv(log, path("clean.csv"));
    logs::write_column_map(log, path("map.toml"));
    std::ifstream in(path("clean.csv"));
    std::ofstream out(path(name));
    int number = 0;
    for (std::string line; std::getline(in, line); ++number) {
      out << spoil(number, line) << "\n";
    }
  }
  void write(const std::string& name, const SyntheticAxis& vehicle, double start_s = 0.0) const {
    write(name, vehicle, start_s, [](int, const std::string& line) { return line; });
  }

  /// Writes a.csv and b.csv: one vehicle, whose neutral point lies on one side of the middle and then on the other.
  void write_two_trims(double duration_s) const {
    SyntheticAxis vehicle;
    vehicle.duration_s = duration_s;
    vehicle.hidden = {{"trim_offset", 25.0}};
    write("a.csv", vehicle);
    vehicle.seed = 2;
    vehicle.hidden = {{"trim_offset", -25.0}};
    write("b.csv", vehicle, 300.0);
  }

  /// The answer as JSON, or the program's error message.
  std::pair<Json, std::string> ask(const std::vector<std::string>& options) const {
    std::vector<std::string> words{"identify", "--columns",      path("map.toml"), "--axis", "roll",
                                   "--json",   path("out.json"), "--draws",        "0"};
    words.insert(words.end(), options.begin(), options.end());
    if (std::find(options.begin(), options.end(), "--declare") == options.end()) {
      words.insert(words.end(), {"--declare", "second_order,transport_delay"});
    }
    const std::string said = refusal_of(add_identify, words);
    return {said.empty() ? Json::parse(whole_file(path("out.json"))) : Json(), said};
  }

  static std::string gaps_in(const Json& answer) {
    for (const Json& finding : answer["findings"]) {
      std::string text = finding.is_string() ? finding.get<std::string>() : finding.dump();
      if (text.find("gap") != std::string::npos && text.find("missing or spoilt") != std::string::npos) {
        return text;
      }
    }
    return "";
  }

 private:
  std::filesystem::path folder_;
};

TEST_F(SeveralLogs, ShareTheirParameters) {
  SyntheticAxis vehicle;
  vehicle.duration_s = 25.0;
  write("a.csv", vehicle);
  vehicle.seed = 2;
  write("b.csv", vehicle, 300.0);  // a clock of its own
  const auto [answer, said] = ask({"--log", path("a.csv"), "--log", path("b.csv"), "--train", "1@2:14,2@302:314",
                                   "--validate", "1@14:24,2@314:324"});
  ASSERT_EQ(said, "");
  const Json& found = answer["final"]["parameters"];
  // 24 s with air of 0.004 rad and tilts of 0.1 rad: the frequency is known to a few percent.
  EXPECT_NEAR(found["natural_frequency_rad_s"].get<double>(), 8.5, 0.05 * 8.5);
  EXPECT_NEAR(found["damping_ratio"].get<double>(), 0.68, 0.08);
  EXPECT_EQ(answer["verdict"], "nothing_missing") << answer["unexplained"];
  EXPECT_EQ(gaps_in(answer), "") << "the pause between the logs is no gap of theirs";
}

// Catches one neutral point for both flights: it is found as a change at their joint. Gains and dynamics are shared.
TEST_F(SeveralLogs, HaveTrimsOfTheirOwn) {
  SyntheticAxis vehicle;
  vehicle.duration_s = 30.0;
  vehicle.hidden = {{"dead_zone", 20.0}, {"trim_offset", 40.0}};
  write("a.csv", vehicle);
  vehicle.seed = 2;
  vehicle.hidden = {{"dead_zone", 20.0}, {"trim_offset", -20.0}};
  write("b.csv", vehicle, 300.0);
  const auto [answer, said] = ask({"--log", path("a.csv"), "--log", path("b.csv"), "--split", "alternate:5"});
  ASSERT_EQ(said, "");
  EXPECT_TRUE(answer["changes"].empty()) << answer["changes"];
  EXPECT_EQ(answer["verdict"], "explained") << answer["unexplained"];
  std::map<std::string, double> found;
  for (const Json& effect : answer["effects"]) {
    for (const auto& [name, value] : effect["parameters"].items()) {
      found[name] = value.is_object() ? value["value"].get<double>() : 0.0;
    }
  }
  EXPECT_NEAR(found["width_counts"], 20.0, 4.0);
  EXPECT_NEAR(found["offset_counts"], 10.0, 4.0) << "the mean of both";
  std::string trims;
  for (const Json& finding : answer["findings"]) {
    const std::string text = finding["text"].get<std::string>();
    trims = text.find("trim of its own") != std::string::npos ? text : trims;
  }
  ASSERT_NE(trims.find("log 1 +"), std::string::npos) << trims;
  EXPECT_NEAR(std::stod(trims.substr(trims.find("log 1 +") + 7)), 30.0, 5.0) << trims;
}

// The mean of both trims is zero, so no common trim is found. Catches the verdict "nothing missing" for a model that
// neither flight alone would get one for.
TEST_F(SeveralLogs, DistinctTrimsMustBeDeclared) {
  write_two_trims(30.0);
  const std::vector<std::string> two{"--log", path("a.csv"), "--log", path("b.csv"), "--split", "alternate:5"};
  const auto [answer, said] = ask(two);
  ASSERT_EQ(said, "");
  EXPECT_EQ(answer["verdict"], "unexplained") << answer["findings"];
  EXPECT_NE(answer["unexplained"].dump().find("neutral points"), std::string::npos) << answer["unexplained"];
  std::vector<std::string> declared = two;
  declared.insert(declared.end(), {"--declare", "second_order,transport_delay,trim_offset"});
  const auto [healthy, said_then] = ask(declared);
  ASSERT_EQ(said_then, "");
  EXPECT_EQ(healthy["verdict"], "nothing_missing") << healthy["unexplained"];
}

// A flight that is only in the validation part must not influence the fit: its other trim is a step between the
// flights, with its size, and no trim of its own.
TEST_F(SeveralLogs, ATrimIsNotFittedOnWhatIsQuoted) {
  write_two_trims(45.0);
  const auto [answer, said] =
      ask({"--log", path("a.csv"), "--log", path("b.csv"), "--train", "1@2:38", "--validate", "2@302:312"});
  ASSERT_EQ(said, "");
  EXPECT_NE(answer["verdict"], "nothing_missing");
  EXPECT_EQ(answer["findings"].dump().find("trim of its own"), std::string::npos) << answer["findings"];
  ASSERT_EQ(answer["changes"].size(), 1U) << answer["changes"];
  EXPECT_EQ(answer["changes"][0]["name"], "trim_offset");
  EXPECT_NEAR(answer["changes"][0]["parameters"]["before_counts"].get<double>(), 25.0, 5.0);
  EXPECT_NEAR(answer["changes"][0]["parameters"]["after_counts"].get<double>(), -25.0, 5.0);
}

// A drift starts anew with every flight. With one clock for both, the drift of the second flight would be ten times too
// large.
TEST_F(SeveralLogs, DriftFromTheirOwnStart) {
  SyntheticAxis vehicle;
  vehicle.hidden = {{"gain_drift", 0.4}};
  write("a.csv", vehicle);
  vehicle.seed = 2;
  write("b.csv", vehicle, 600.0);
  const auto [answer, said] = ask({"--log", path("a.csv"), "--log", path("b.csv"), "--split", "alternate:5"});
  ASSERT_EQ(said, "");
  ASSERT_EQ(answer["effects"].size(), 1U) << answer["effects"];
  EXPECT_EQ(answer["effects"][0]["name"], "gain_drift");
  EXPECT_NEAR(answer["effects"][0]["parameters"]["fraction_per_minute"]["value"].get<double>(), 0.4, 0.1);
}

TEST_F(SeveralLogs, RangesNameTheirLog) {
  SyntheticAxis vehicle;
  vehicle.duration_s = 25.0;
  write("a.csv", vehicle);
  const std::vector<std::string> two{"--log", path("a.csv"), "--log", path("a.csv")};
  const auto refused = [&](const std::string& train, const char* what) {
    std::vector<std::string> words = two;
    words.insert(words.end(), {"--train", train, "--validate", "2@12:24"});
    const std::string said = ask(words).second;
    EXPECT_NE(said.find(what), std::string::npos) << said;
  };
  refused("2:12", "names its log");
  refused("3@2:12", "names a log that was not given");
  refused("0@2:12", "names a log that was not given");
  refused("2@2:99", "outside of the log");
  refused("2@2:14", "overlaps");
}

TEST_F(SeveralLogs, SplitStaysWithin) {
  write("a.csv", SyntheticAxis{});
  const auto [whole, said_whole] = ask({"--log", path("a.csv"), "--split", "alternate:5", "--within", "5:40"});
  ASSERT_EQ(said_whole, "");
  const auto [same, said_same] =
      ask({"--log", path("a.csv"), "--train", "5:10,15:20,25:30,35:40", "--validate", "10:15,20:25,30:35"});
  ASSERT_EQ(said_same, "");
  EXPECT_EQ(whole["final"], same["final"]);
  write("b.csv", SyntheticAxis::random(2), 0.0,
        [](int row, const std::string& line) { return row == 9 ? line + "\n" + line : line; });
  const Json cut =
      ask({"--log", path("a.csv"), "--validate-log", path("b.csv"), "--split", "alternate:5", "--within", "5:20"})
          .first;
  EXPECT_EQ(cut["final"], ask({"--log", path("a.csv"), "--validate-log", path("b.csv"), "--train", "5:10,10:15,15:20",
                               "--validate", "0:44.99"})
                              .first["final"]);
  EXPECT_NE(cut["findings"].dump().find("validation log: t_s: 1 repeated"), std::string::npos) << cut["findings"];
  EXPECT_NE(ask({"--log", path("a.csv"), "--train", "5:20", "--validate", "20:30", "--within", "5:30"}).second, "");
}

// A spoilt row outside of the ranges does not matter; inside it is a counted gap.
TEST_F(SeveralLogs, SpoiltRowsMatterInsideOfTheRangesOnly) {
  const std::vector<std::string> ranges{"--train", "3:24", "--validate", "24:40"};
  const auto with = [&](int from, int to) {
    write("a.csv", SyntheticAxis{}, 0.0, [&](int number, const std::string& line) {
      return number >= from && number < to ? line.substr(0, line.find(',')) + ",nan,what,3" : line;
    });
    std::vector<std::string> words{"--log", path("a.csv")};
    words.insert(words.end(), ranges.begin(), ranges.end());
    return ask(words);
  };
  const auto [clean, said_clean] = with(0, 0);
  const auto [outside, said_outside] = with(4200, 4230);
  const auto [inside, said_inside] = with(1000, 1030);
  ASSERT_EQ(said_clean + said_outside + said_inside, "");
  EXPECT_EQ(outside["final"], clean["final"]);
  EXPECT_EQ(gaps_in(clean), "");
  EXPECT_EQ(gaps_in(outside), "");
  EXPECT_NE(gaps_in(inside).find("30 samples"), std::string::npos) << gaps_in(inside);
}

TEST_F(SeveralLogs, NothingThatIsReadIsOverwritten) {
  write("a.csv", SyntheticAxis{});
  const auto said = ask({"--log", path("a.csv"), "--split", "alternate:5", "--vehicle", path("a.csv")}).second;
  EXPECT_NE(said.find("would be overwritten"), std::string::npos) << said;
  EXPECT_NE(ask({"--log", path("a.csv"), "--split", "alternate:5", "--vehicle", "/nowhere/v.toml"})
                .second.find("cannot be written"),
            std::string::npos);
  std::ofstream(path("out.json")) << R"({"forecast": {}})";  // the fixture's --json file
  for (const char* option : {"--forecast", "--vehicle-believed"}) {
    EXPECT_NE(ask({"--log", path("a.csv"), "--split", "alternate:5", option, path("out.json")})
                  .second.find("would be overwritten"),
              std::string::npos)
        << option;
  }
}

// The other subcommands that write files next to their input.
TEST_F(SeveralLogs, NothingThatIsReadIsOverwrittenByInjectAndReport) {
  write("a.csv", SyntheticAxis{});
  const auto size_of = [&](const char* name) { return std::filesystem::file_size(path(name)); };
  const auto log_size = size_of("a.csv");
  const auto map_size = size_of("map.toml");
  const auto inject = [&](const std::string& out, const std::string& map) {
    return refusal_of(add_inject, {"inject", "--log", path("a.csv"), "--columns", path("map.toml"), "--axis", "roll",
                                   "--train", "3:24", "--effect", "dead_zone=20", "--out", out, "--map", map});
  };
  EXPECT_NE(inject(path("a.csv"), path("new.toml")).find("would be overwritten"), std::string::npos);
  EXPECT_NE(inject(path("new.csv"), path("map.toml")).find("would be overwritten"), std::string::npos);
  EXPECT_NE(inject("/nowhere/new.csv", path("new.toml")).find("cannot be written"), std::string::npos);
  EXPECT_EQ(size_of("a.csv"), log_size);
  EXPECT_EQ(size_of("map.toml"), map_size);

  std::ofstream(path("page.html")) << "<html><title>a</title><body>b</body></html>";
  const auto page_size = size_of("page.html");
  EXPECT_NE(
      refusal_of(add_report, {"report", path("page.html"), "--out", path("page.html")}).find("would be overwritten"),
      std::string::npos);
  EXPECT_EQ(size_of("page.html"), page_size);
}

// No vehicle file may be written from a gain whose sign is probably an error of the column map, or from a log with a
// wrong clock.
TEST_F(SeveralLogs, AVehicleFileIsNotWrittenFromAMisreadLog) {
  SyntheticAxis reversed;
  reversed.gain_rad = -reversed.gain_rad;
  write("reversed.csv", reversed);
  SyntheticAxis early;
  early.delay_s = 0.0;
  logs::FlightLog log = early.fly();
  std::vector<double>& stick = log.of(logs::Signal::kStickRoll);
  std::rotate(stick.rbegin(), stick.rbegin() + 6, stick.rend());  // the stick comes 60 ms after its response
  logs::write_csv(log, path("early.csv"));
  write("healthy.csv", SyntheticAxis{});
  for (const char* name : {"reversed.csv", "early.csv", "healthy.csv"}) {
    std::filesystem::remove(path("out.json"));
    const auto [answer, said] =
        ask({"--log", path(name), "--split", "alternate:5", "--within", "2:44", "--vehicle", path("new.toml")});
    const bool healthy = std::string(name) == "healthy.csv";
    EXPECT_EQ(said.empty(), healthy) << name << ": " << said;
    EXPECT_EQ(std::filesystem::exists(path("new.toml")), healthy) << name;
    EXPECT_TRUE(std::filesystem::exists(path("out.json"))) << name << ": what was found is told all the same";
  }
}

// Validation on training data is refused, also under another file name: the quoted error must come from unseen data.
TEST_F(SeveralLogs, TrainingDataDoNotComeBackForValidation) {
  write("a.csv", SyntheticAxis{});
  std::filesystem::copy_file(path("a.csv"), path("again.csv"));
  const auto says = [&](const std::vector<std::string>& words, const char* what) {
    const std::string said = ask(words).second;
    EXPECT_NE(said.find(what), std::string::npos) << what << ": " << said;
  };
  const std::vector<std::string> twice{"--log", path("a.csv"), "--log", path("a.csv")};
  const std::vector<std::string> copied{"--log", path("a.csv"), "--log", path("again.csv")};
  const auto with = [](std::vector<std::string> words, const char* train, const char* validate) {
    words.insert(words.end(), {"--train", train, "--validate", validate});
    return words;
  };
  for (const auto& logs : {twice, copied}) {
    says(with(logs, "1@3:24", "2@3:24"), "data the fit has seen");
    says(with(logs, "1@3:24", "2@20:40"), "data the fit has seen");
    says(with(logs, "1@3:24,2@10:30", "2@30:40"), "count twice");
  }
  EXPECT_EQ(ask(with(copied, "1@3:20", "2@20:40")).second, "");  // different parts of one flight
  std::vector<std::string> split = twice;
  split.insert(split.end(), {"--split", "alternate:5"});
  says(split, "count twice");
  says({"--log", path("a.csv"), "--validate-log", path("again.csv"), "--train", "3:24", "--validate", "3:24"},
       "data the fit has seen");
  says({"--log", path("a.csv"), "--train", "3:20,10:24", "--validate", "24:40"}, "count twice");
  says({"--log", path("a.csv"), "--train", "3:24", "--validate", "24:40", "--validate-columns", path("map.toml")},
       "--validate-log");
}

// The same stick script flown twice is two flights, because the measurements differ.
TEST_F(SeveralLogs, ARepeatedScriptIsAnotherFlight) {
  logs::FlightLog log = SyntheticAxis{}.fly();
  logs::write_csv(log, path("a.csv"));
  logs::write_column_map(log, path("map.toml"));
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0.0, 0.002);
  for (double& value : log.of(logs::Signal::kAttitudeRoll)) {
    value += noise(random);
  }
  logs::write_csv(log, path("b.csv"));
  EXPECT_EQ(
      ask({"--log", path("a.csv"), "--validate-log", path("b.csv"), "--train", "3:24", "--validate", "3:24"}).second,
      "");
  EXPECT_EQ(
      ask({"--log", path("a.csv"), "--log", path("b.csv"), "--train", "1@3:24,2@3:24", "--validate", "1@24:40,2@24:40"})
          .second,
      "");
}

}  // namespace
}  // namespace m100::lab
