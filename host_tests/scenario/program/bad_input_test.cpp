// SPDX-License-Identifier: BSD-3-Clause
// Wrong use and bad input: exit code 2 and one line on stderr that names the file, and the line or key where there is
// one. `m100 check`, whose answer may be no.
#include <algorithm>

#include "host_tests/scenario/program/program_fixture.h"

namespace m100::scenario {
namespace {

struct BadInput : ProgramTest {
  /// One line, exit code 2, and what it must name.
  void expect_refused(const std::vector<std::string>& arguments, const std::string& named) {
    EXPECT_EQ(run(arguments), 2) << arguments.back();
    const std::string said = error();
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    EXPECT_NE(said.find(named), std::string::npos) << said << " does not name " << named;
  }
  /// The default vehicle file with one text replaced.
  fs::path changed(const std::string& from, const std::string& to) {
    std::string text = text_of(vehicle);
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    const fs::path path = folder / "changed.toml";
    std::ofstream(path, std::ios::trunc) << text;
    return path;
  }
  fs::path file(const std::string& name, const std::string& text) {
    std::ofstream(folder / name, std::ios::trunc) << text;
    return folder / name;
  }
  std::vector<std::string> check(const fs::path& vehicle_file, const fs::path& table_file) const {
    return {"check", "--vehicle", vehicle_file.string(), "--gains", table_file.string()};
  }
};

TEST_F(BadInput, OfTheCommandLineIsNamed) {
  expect_refused({}, "subcommand");
  expect_refused({"land"}, "'land'");
  expect_refused({"fly"}, "--port");
  expect_refused({"fly", "--dry-run", "--port", "x", "--baud", "9600"}, "--baud");
  expect_refused({"fly", "--dry-run", "--port", "x", "--hold", "nan"}, "--hold");
  expect_refused({"fly", "--dry-run", "--port", "x", "--app-id", "-1"}, "--app-id");
  expect_refused({"fly", "--dry-run", "--port", "x", "--rate", "26"}, "--rate");
  expect_refused({"fly", "--dry-run", "--port", "x", "--rate", "nan"}, "--rate");
  expect_refused({"fly", "--dry-run", "--port", "x", "--nonsense"}, "--nonsense");
  expect_refused({"replay", "x", "--scalar", "half"}, "--scalar");
}

TEST_F(BadInput, OfAPortSaysWhetherItIsMissingOrNoPort) {
  const std::string missing = (folder / "none").string();
  expect_refused({"fly", "--dry-run", "--port", missing}, missing + ": no such serial port");
  expect_refused({"fly", "--dry-run", "--port", folder.string()}, folder.string() + ": is not a serial port");
  expect_refused({"fly", "--dry-run", "--port", table.string()}, table.string() + ": is not a serial port");
  expect_refused({"fly", "--dry-run", "--port", missing, "--json", (folder / "no" / "x.json").string()}, "x.json");
  expect_refused({"fly", "--dry-run", "--port", missing, "--key-file", missing}, "none: cannot be read");
  expect_refused({"fly", "--dry-run", "--port", missing, "--key-file", file("key", "12 34").string()}, "key:1:");
}

TEST_F(BadInput, OfAVehicleFileIsNamedByLineAndKey) {
  expect_refused(check(folder / "none.toml", table), "none.toml");
  expect_refused(check(folder, table), folder.string());
  expect_refused(check(file("empty.toml", ""), table), "empty.toml");
  expect_refused(check(table, table), "table.bin:1");
  expect_refused(check(changed("[axis.roll]", "[axis.roll]\nflaps = 1"), table), "'axis.roll.flaps'");
  const fs::path range = changed("damping_ratio = ", "damping_ratio = -");
  expect_refused(check(range, table), "damping_ratio");
  const std::string head = text_of(range).substr(0, text_of(range).find("damping_ratio = -"));
  expect_refused(check(range, table), "changed.toml:" + std::to_string(1 + std::count(head.begin(), head.end(), '\n')));
}

TEST_F(BadInput, OfAGainTableIsRefusedWithTheReason) {
  RecordProperty("promise", "R10");
  expect_refused(check(vehicle, folder / "none.bin"), "none.bin: cannot be read");
  expect_refused(check(vehicle, folder), folder.string());
  expect_refused(check(vehicle, vehicle), "not a gain table");
  expect_refused(check(changed("source = ", "# another day\nsource = "), table), "made from another vehicle file");
  std::string bytes = text_of(table);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  expect_refused(check(vehicle, file("flipped.bin", bytes)), "flipped.bin: damaged");
  expect_refused(check(vehicle, file("cut.bin", text_of(table).substr(0, 1000))), "cut.bin");
}

TEST_F(BadInput, OfALogNamesTheFileAndTheByte) {
  expect_refused({"replay", (folder / "none.ulg").string()}, "none.ulg");
  expect_refused({"replay", folder.string()}, folder.string());
  expect_refused({"replay", table.string()}, "table.bin: byte 0");
  expect_refused({"replay", file("empty.ulg", "").string()}, "empty.ulg: byte 0");
  expect_refused({"replay", table.string(), "--key-file", "none"}, "none");
}

TEST_F(BadInput, OfAFlightIsFoundBeforeTheFlight) {
  const auto autopilot = start_autopilot();
  const auto fly_with = [this](const std::string& option, const fs::path& value) {
    return flight({"--hold", "1", option, value.string()});
  };
  expect_refused(fly_with("--course", file("hop.course", "# up\nhop 1\n")), "hop.course:2: 'hop'");
  expect_refused(fly_with("--course", file("short.course", "step 0 0 1\n")), "short.course:1: 'step'");
  expect_refused(fly_with("--course", file("back.course", "step 0 0 0 0 -1\n")), "back.course:1: 'step'");
  expect_refused(fly_with("--course", folder / "none.course"), "none.course");
  expect_refused(fly_with("--log", file("there.ulg", "x")), "there.ulg: exists already");
  EXPECT_EQ(text_of(folder / "there.ulg"), "x");
  expect_refused(fly_with("--log", folder / "no" / "x.ulg"), "x.ulg: cannot be written");
  expect_refused(fly_with("--json", folder / "no" / "x.json"), "x.json: cannot be written");
  expect_refused({"fly", "--port", port.string(), "--pose-port", port.string(), "--vehicle", vehicle.string(),
                  "--gains", table.string()},
                 "port: no right to open it, or another program holds it");
  EXPECT_EQ(examined(*autopilot)["obtain_requests"], 0);
}

TEST_F(BadInput, OfTheEmulatedAutopilotIsNamed) {
  const auto expect_lab_refused = [this](std::vector<std::string> more, const std::string& named) {
    more.insert(more.begin(), {"autopilot", "--pty", port.string(), "--duration", "1"});
    EXPECT_EQ(run_lab(more), 2) << more.back();
    const std::string said = error();
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    EXPECT_NE(said.find(named), std::string::npos) << said << " does not name " << named;
  };
  expect_lab_refused({"--script", folder.string()}, folder.string());
  expect_lab_refused({"--script", file("s", "1 mode F\n2 mode Q\n").string()}, "s:2");
  expect_lab_refused({"--plant", file("p.toml", "[air]\nwind_m_s = 3\n").string()}, "p.toml:2: 'air.wind_m_s'");
  expect_lab_refused({"--pose-pty", port.string()}, "--pose-pty");
  expect_lab_refused({"--duration", "nan"}, "--duration");
  expect_lab_refused({"--loss", "nan"}, "--loss");
  expect_lab_refused({"--events", (folder / "no" / "e").string()}, "e: cannot be written");
}

TEST_F(BadInput, CheckSaysYesToWhatBelongsTogetherAndNoToWhatIsUnsafe) {
  EXPECT_EQ(run(check(vehicle, table)), 0);
  // A vehicle whose trim leaves no room for the stick: a file in order, a table made from it, and yet the answer is no.
  std::string text = text_of(vehicle);
  const std::size_t at = text.find("trim_counts = ");
  ASSERT_NE(at, std::string::npos);
  const std::size_t end = text.find('\n', at);
  text.replace(at, end - at, "trim_counts = 250.0");
  const fs::path far = file("far.toml", text);
  ASSERT_EQ(run_lab({"gains", "--vehicle", far.string(), "--table", (folder / "far.bin").string()}), 0) << error();
  EXPECT_EQ(run(check(far, folder / "far.bin")), 1);
}

}  // namespace
}  // namespace m100::scenario
