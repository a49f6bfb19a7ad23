// SPDX-License-Identifier: BSD-3-Clause
// Wrong use and bad input: exit code 2 and one line on stderr that names the file and, if possible, the line or key.
// Also tests `m100 check`, whose answer may be no.
#include <algorithm>

#include "host_tests/scenario/program/program_fixture.h"

namespace m100::scenario {
namespace {

struct BadInput : ProgramTest {
  /// Expects exit code 2 and one line that contains `named`.
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
    return made("changed.toml", text);
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
  expect_refused({"fly", "--port", "x", "--live", "localhost:9870"}, "--live");  // before the port is opened
  expect_refused({"handshake", "--port", "/dev/null", "--rate", "100"}, "--rate");
  expect_refused({"doctor", "--pose-rate", "nan"}, "--pose-rate");
  expect_refused({"doctor", "--pose-port", "x", "--pose-baud", "nan"}, "--pose-baud");
  expect_refused({"doctor", "--frames", "--port", "x", "--pose-port", "y", "--hold", "nan"}, "--hold");
  expect_refused({"replay", "x", "--scalar", "half"}, "--scalar");
}

// A shell replaces an unset variable by an empty word. Ignoring it would be dangerous: without the course the aircraft
// would hover, without the key file it would fly unencrypted, and `check` would not read the flight file at all.
TEST_F(BadInput, AnEmptyWordIsNoName) {
  expect_refused({"check", "--vehicle", vehicle.string(), "--gains", table.string(), "--flight", ""}, "--flight");
  expect_refused({"check", "--vehicle", "", "--gains", table.string()}, "--vehicle");
  expect_refused({"fly", "--dry-run", "--port", "x", "--course", ""}, "--course");
  expect_refused({"fly", "--dry-run", "--port", "x", "--key-file", ""}, "--key-file");
  expect_refused({"replay", ""}, "log");
}

TEST_F(BadInput, OfAPortSaysWhetherItIsMissingOrNoPort) {
  const std::string missing = (folder / "none").string();
  expect_refused({"fly", "--dry-run", "--port", missing}, missing + ": no such serial port");
  expect_refused({"handshake", "--port", missing}, missing + ": no such serial port");
  expect_refused({"fly", "--dry-run", "--port", folder.string()}, folder.string() + ": is not a serial port");
  expect_refused({"fly", "--dry-run", "--port", table.string()}, table.string() + ": is not a serial port");
  expect_refused({"fly", "--dry-run", "--port", missing, "--json", (folder / "no" / "x.json").string()}, "x.json");
  expect_refused({"fly", "--dry-run", "--port", missing, "--key-file", missing}, "none: cannot be read");
  expect_refused({"fly", "--dry-run", "--port", missing, "--key-file", key_file("12 34").string()}, "key:1:");
  const fs::path key = key_file(std::string(64, 'a'));
  for (const fs::perms other : {fs::perms::others_read, fs::perms::group_read, fs::perms::others_write}) {
    fs::permissions(key, fs::perms::owner_read | other);
    expect_refused({"handshake", "--port", missing, "--key-file", key.string()},
                   "others can read: chmod 600 " + key.string());
  }
}

// A key that others can read through a link, a malformed key, and a key on the command line, where everybody sees it.
TEST_F(BadInput, OfAKeyFileIsRefusedWithTheRemedy) {
  RecordProperty("promise", "R14");
  const std::string digits(64, 'a');
  const fs::path key = key_file(digits), link = folder / "link";
  fs::create_symlink(key, link);
  const auto handshake = [](const std::string& path) {
    return std::vector<std::string>{"handshake", "--port", "/dev/null", "--key-file", path};
  };
  expect_refused(handshake(link.string()), "/dev/null");  // the key is valid under any name; only the port is refused
  fs::permissions(key, fs::perms::owner_read | fs::perms::group_read);
  expect_refused(handshake(link.string()), "link: holds a key that others can read: chmod 600");
  expect_refused(handshake(folder.string()), "is a folder");
  expect_refused(handshake(key_file("").string()), "64 hexadecimal digits");
  expect_refused(handshake(key_file(digits + "00").string()), "64 hexadecimal digits");
  expect_refused(handshake(key_file(digits + "\n" + digits).string()), "key:2: something follows");
  expect_refused(handshake(key_file(std::string(2U << 20U, 'a')).string()), "is larger than 1 MiB");
  for (const std::vector<std::string>& words :
       {handshake(digits), {"handshake", "--port", "/dev/null", "--key", digits}}) {
    expect_refused(words, "a key belongs in a file");
    EXPECT_EQ(error().find(digits), std::string::npos) << "the message must not contain the key";
  }
}

TEST_F(BadInput, OfAVehicleFileIsNamedByLineAndKey) {
  expect_refused(check(folder / "none.toml", table), "none.toml");
  expect_refused(check(folder, table), folder.string());
  expect_refused(check(made("empty.toml", ""), table), "empty.toml");
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
  expect_refused(check(vehicle, made("flipped.bin", bytes)), "flipped.bin: damaged");
  // The file has a table for each mode; the table of the other mode must be intact, too.
  const std::string both = text_of(table);
  const std::size_t second = both.find(both.substr(0, 8), 8);
  ASSERT_NE(second, std::string::npos);
  for (const std::size_t at : {std::size_t{20}, second - 1, second, second + 20, both.size() - 1}) {
    std::string damaged = both;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    expect_refused(check(vehicle, made("flipped.bin", damaged)), "flipped.bin: damaged");
  }
  expect_refused(check(vehicle, made("twice.bin", both + both)), "twice.bin");
  constexpr const char* kRest = "[fence]\nx_m = [-5, 5]\ny_m = [-5, 5]\nz_m = [0.5, 4]\n";
  const auto check_in = [&](const char* mode, const fs::path& tables) {
    const std::string text = "mode = \"" + std::string(mode) + "\"\n" + kRest;
    return with(check(vehicle, tables), {"--flight", made(std::string(mode) + ".toml", text)});
  };
  EXPECT_EQ(run(check_in("robust", table)), 0) << error();
  EXPECT_EQ(run(check_in("calm_room", table)), 0) << "the former mode is flown with field: " << error();
  const fs::path field = made("field.bin", both.substr(0, second));
  EXPECT_EQ(run(check(vehicle, field)), 0) << "a file with only the table of the flown mode: " << error();
  expect_refused(check_in("robust", field), "field.bin: has no table of mode robust");
  expect_refused(check(vehicle, made("cut.bin", text_of(table).substr(0, 1000))), "cut.bin");
}

TEST_F(BadInput, OfAFlightFileIsNamedByLineAndKey) {
  const auto check_flight = [this](const fs::path& path) {
    return with(check(vehicle, table), {"--flight", path.string()});
  };
  EXPECT_EQ(run(check_flight(flight_file)), 0) << "the shipped example: " << error();
  expect_refused(check_flight(folder / "none.toml"), "none.toml: cannot be read");
  expect_refused(check_flight(made("f.toml", "[fence]\nx_m = [-1, 1]\ny_m = [-1, 1]\n")), "f.toml:1: 'fence.z_m'");
  expect_refused(check_flight(made("f.toml", "mode = \"storm\"\n")), "f.toml:1: 'mode'");
}

// `check` at the desk refuses the same courses as `fly` at the aircraft, with the same message.
TEST_F(BadInput, OfACourseIsFoundAtTheDesk) {
  const fs::path box = made("box.toml", "[fence]\nx_m = [-2, 2]\ny_m = [-2, 2]\nz_m = [0.5, 3.5]\n");
  const auto check_course = [&](const fs::path& course) {
    return with(check(vehicle, table), {"--flight", box.string(), "--course", course.string()});
  };
  EXPECT_EQ(run(check_course(made("good.course", "quintic 1 0 1 0 5\nsquare 1 2 0.2\n"))), 0) << error();
  expect_refused(check_course(folder / "none.course"), "none.course: cannot be read");
  expect_refused(check_course(made("empty.course", "# to be written\n\n")), "empty.course: has no piece");
  expect_refused(check_course(made("hop.course", "# up\nhop 1\n")), "hop.course:2: 'hop'");
  expect_refused(check_course(made("far.course", "step 1 0 0 0 5\nstep 100 0 0 0 5\n")),
                 "far.course:2: 'step': x = 100 m is outside the fence");
  expect_refused(check_course(made("high.course", "step 0 0 2 0 5\nstep 0 0 -1.5 0 5\n")),
                 "high.course:1: 'step': z = ");
  expect_refused(with(check(vehicle, table), {"--course", made("back.course", "step 0 0 0 0 -1\n")}),
                 "back.course:1: 'step'");
}

TEST_F(BadInput, OfALogNamesTheFileAndTheByte) {
  expect_refused({"replay", (folder / "none.ulg").string()}, "none.ulg");
  expect_refused({"replay", folder.string()}, folder.string());
  expect_refused({"replay", table.string()}, "table.bin: byte 0");
  expect_refused({"replay", made("empty.ulg", "")}, "empty.ulg: byte 0");
  expect_refused({"replay", table.string(), "--key-file", "none"}, "none");
}

// Catches a program that reads a device for ever.
TEST_F(BadInput, ADeviceIsNotReadToItsEnd) {
  const std::string zero = "/dev/zero";
  expect_refused({"replay", zero}, zero + ": is not a regular file");
  expect_refused(check(zero, table), zero + ": is not a regular file");
  expect_refused(check(vehicle, zero), zero + ": is not a regular file");
  expect_refused(with(check(vehicle, table), {"--flight", zero}), zero + ": is not a regular file");
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"gains", "--vehicle", zero, "--table", (folder / "t.bin").string()},
        std::vector<std::string>{"mpc", "solve", zero},
        std::vector<std::string>{"autopilot", "--pty", port.string(), "--script", zero}}) {
    EXPECT_EQ(run_lab(words), 2) << words.front();
    EXPECT_NE(error().find(zero + ": is not a regular file"), std::string::npos) << error();
  }
}

// Regression test: an answer that could not be written to a full disk was lost without a message.
TEST_F(BadInput, AnAnswerThatCannotBeWrittenIsNotDone) {
  const std::string asked[] = {
      std::string(M100_PROGRAM) + " check --vehicle " + vehicle.string() + " --gains " + table.string(),
      std::string(M100_LAB_PROGRAM) + " reference"};
  for (const std::string& words : asked) {
    EXPECT_EQ(Process("/bin/sh", {"-c", words + " > /dev/full"}, errors).wait(), 2) << words;
    EXPECT_NE(error().find("standard output: cannot be written"), std::string::npos) << error();
    EXPECT_EQ(Process("/bin/sh", {"-c", words + " >&-"}, errors).wait(), 0) << words << " " << error();
  }
}

// The tables take minutes on a small machine, so an unwritable output must be reported before.
TEST_F(BadInput, OfGainsAreTheOutputsFirst) {
  const fs::path copy = made("copy.toml", text_of(vehicle));
  fs::create_symlink(copy, folder / "link.toml");
  for (const fs::path& output : {copy, folder / "link.toml", folder / "no" / "t.bin"}) {
    EXPECT_EQ(run_lab({"gains", "--vehicle", copy.string(), "--table", output.string()}), 2);
    EXPECT_NE(error().find(output.string()), std::string::npos) << error();
  }
  EXPECT_EQ(text_of(copy), text_of(vehicle));
}

TEST_F(BadInput, ATimeStepThatIsNoneIsRefused) {
  const std::string model =
      R"({"type":"model","name":"m","nx":3,"N":20,"A":[[1,0.1,0],[0,1,0.9],[0,0,0.8]],"B":[0,0,0.2],"Bd":[0,0.1,0],)"
      R"("Q":[1,1,1],"R":1,"Rd":0,"P":[[1,0,0],[0,1,0],[0,0,1]],"u_min":-1,"u_max":1,"dt":)";
  for (const char* step : {"0", "-0.1", "1e-30", "1e300", "null"}) {
    EXPECT_EQ(run_lab({"mpc", "solve", made("m.jsonl", model + step + "}\n")}), 2) << step;
    EXPECT_NE(error().find("m.jsonl:1: 'dt'"), std::string::npos) << error();
  }
}

TEST_F(BadInput, OfAFlightIsFoundBeforeTheFlight) {
  const auto autopilot = start_autopilot();
  const auto fly_with = [this](const std::string& option, const fs::path& value) {
    return flight({"--hold", "1", option, value.string()});
  };
  expect_refused(fly_with("--course", made("hop.course", "# up\nhop 1\n")), "hop.course:2: 'hop'");
  expect_refused(fly_with("--course", made("short.course", "step 0 0 1\n")), "short.course:1: 'step'");
  expect_refused(fly_with("--course", made("back.course", "step 0 0 0 0 -1\n")), "back.course:1: 'step'");
  expect_refused(fly_with("--course", folder / "none.course"), "none.course");
  expect_refused(fly_with("--course", made("far.course", "step 1 0 0 0 5\nstep 100 0 0 0 5\n")),
                 "far.course:2: 'step': x = 100 m is outside the fence");
  expect_refused(fly_with("--course", made("low.course", "quintic 0 0 -3 0 5\n")), "low.course:1: 'quintic': z = ");
  expect_refused({"fly", "--port", port.string(), "--pose-port", pose.string(), "--vehicle", vehicle.string(),
                  "--gains", table.string()},
                 "--flight");
  expect_refused(fly_with("--log", made("there.ulg", "x")), "there.ulg: exists already");
  EXPECT_EQ(text_of(folder / "there.ulg"), "x");
  expect_refused(fly_with("--log", folder / "no" / "x.ulg"), "x.ulg: cannot be written");
  expect_refused(fly_with("--json", folder / "no" / "x.json"), "x.json: cannot be written");
  expect_refused(with({"fly", "--port", port.string(), "--pose-port", port.string()}, models()),
                 "port is the autopilot's port, too: name the port of the poses");
  EXPECT_EQ(examined(*autopilot)["obtain_requests"], 0);
}

TEST_F(BadInput, OfTheEmulatedAutopilotIsNamed) {
  const auto expect_lab_refused = [this](const Words& more, const std::string& named) {
    EXPECT_EQ(run_lab(with({"autopilot", "--pty", port.string(), "--duration", "1"}, more)), 2) << more.back();
    const std::string said = error();
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    EXPECT_NE(said.find(named), std::string::npos) << said << " does not name " << named;
  };
  expect_lab_refused({"--script", folder.string()}, folder.string());
  expect_lab_refused({"--script", made("s", "1 mode F\n2 mode Q\n")}, "s:2");
  expect_lab_refused({"--plant", made("p.toml", "[air]\nwind_m_s = 3\n")}, "p.toml:2: 'air.wind_m_s'");
  expect_lab_refused({"--pose-pty", port.string()}, "--pose-pty");
  expect_lab_refused({"--duration", "nan"}, "--duration");
  expect_lab_refused({"--loss", "nan"}, "--loss");
  expect_lab_refused({"--events", (folder / "no" / "e").string()}, "e: cannot be written");
  expect_lab_refused({"--events", "/dev/full"}, "/dev/full: '--events': cannot be written");
}

TEST_F(BadInput, CheckSaysYesToWhatBelongsTogetherAndNoToWhatIsUnsafe) {
  EXPECT_EQ(run(check(vehicle, table)), 0);
  // A vehicle whose trim leaves no room for the stick: the file is valid and the table fits it, but the answer is no.
  std::string text = text_of(vehicle);
  const std::size_t at = text.find("trim_counts = ");
  ASSERT_NE(at, std::string::npos);
  const std::size_t end = text.find('\n', at);
  text.replace(at, end - at, "trim_counts = 250.0");
  const fs::path far = made("far.toml", text);
  ASSERT_EQ(run_lab({"gains", "--vehicle", far.string(), "--table", (folder / "far.bin").string()}), 0) << error();
  EXPECT_EQ(run(check(far, folder / "far.bin")), 1);
  // `fly` refuses what `check` rejects, unless it is overridden by name; the port is checked after that.
  const auto autopilot = start_autopilot();
  const Words fly{"fly", "--dry-run", "--port", port.string(), "--vehicle", far.string(), "--gains", path("far.bin")};
  expect_refused(fly, "--override trim");
  EXPECT_EQ(run(with(fly, {"--override", "trim", "--hold", "1"})), 0) << error();
}

}  // namespace
}  // namespace m100::scenario
