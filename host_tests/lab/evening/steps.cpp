// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/evening/steps.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "firmware/companion/files/flight_file.h"
#include "firmware/companion/files/vehicle_file.h"
#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/evening/judge.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab::evening {
namespace {

/// Two metres around the place and back, then two circles: what is flown before and after the correction.
constexpr std::string_view kCourse =
    R"(# What is flown before and after the correction. Change it before the step `course`, not after.
quintic 1.5 0 0 0 3
quintic 1.5 1.5 0 0 3
quintic 0 0 0 0 4
circle 1 0.8 2
)";
/// Every M100 balances beside the middle of its sticks (paper, III-A). Not declared, 56 counts of it were once taken
/// for a dead zone of 92, and what is found beside that is no model of the aircraft.
constexpr const char* kDeclared = "second_order,transport_delay,dead_zone,trim_offset";
constexpr double kCalmerFactor = 3.0;  ///< of the input weight, each time that the loop swings
constexpr double kShareOfFence = 0.6;  ///< of an excitation: what unknown tilt adds must end inside the fence too

std::string text(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

Command operator+(Command left, const Command& right) {
  left.insert(left.end(), right.begin(), right.end());
  return left;
}

/// The distance that the flight file leaves to the nearest side.
double least_side_m(const Folder& folder) {
  const companion::FlightFile flight =
      companion::parse_flight(whole_file(folder.file("flight.toml")), folder.file("flight.toml"));
  return std::min({-flight.fence_x_m.low, flight.fence_x_m.high, -flight.fence_y_m.low, flight.fence_y_m.high});
}

/// "FROM:TO" of the excitation, on the log's clock; empty: it was not flown yet.
std::string excited(const Folder& folder) {
  if (!folder.has("excite.json")) {
    return "";
  }
  const nlohmann::json result = nlohmann::json::parse(whole_file(folder.file("excite.json")), nullptr, false);
  if (!result.is_object() || !result.contains("excitation")) {
    return "";
  }
  const nlohmann::json& flown = result["excitation"];
  return text(flown.value("from_s", 0.0)) + ":" + text(flown.value("to_s", 0.0));
}

/// Makes the steps of one folder.
class Maker {
 public:
  explicit Maker(const Folder& folder) : folder_(folder), settings_(folder.settings()) {}

  std::vector<Step> all() const {
    std::vector<Step> out{probe(), record()};
    for (Step& step : std::vector{identify(), gains(), check("check", "vehicle")}) {
      out.push_back(std::move(step));
    }
    out.push_back(handshake());
    out.push_back(hover());
    out.push_back(course("course", "vehicle", "Fly the course with the first vehicle file: the error before."));
    out.push_back(plan());
    out.push_back(excite());
    out.push_back(identify_again());
    out.push_back(gains_again());
    out.push_back(check("check_again", "corrected"));
    out.push_back(
        course("corrected", "corrected", "Fly the same course with the corrected vehicle file: the error after."));
    return out;
  }

 private:
  Command at_port() const { return {"--port", settings_.port, "--baud", std::to_string(settings_.baud)}; }
  Command at_pose() const {
    return {"--pose-port", settings_.pose_port, "--pose-baud", std::to_string(settings_.pose_baud)};
  }
  Command with_key() const {
    return settings_.key_file.empty() ? Command{} : Command{"--key-file", settings_.key_file};
  }
  Command as_app() const {
    return (settings_.app_id == 0 ? Command{} : Command{"--app-id", std::to_string(settings_.app_id)}) + with_key();
  }

  Step probe() const {
    return {.name = "probe",
            .on_board = true,
            .sentence = "Switch the aircraft on, propellers off, and let the board listen: is the autopilot there?",
            .reads = {},
            .makes = {"probe.json"},
            .commands = {Command{"m100", "probe"} + at_port() + Command{"--json", "probe.json"}},
            .judge = [](Folder& folder) { return judge_probe(folder, "probe.json"); }};
  }
  Step record() const {
    return {.name = "record",
            .on_board = true,
            .sentence =
                "Fly by hand in mode P for two minutes, inside the space, and move roll, then pitch, in short pairs of "
                "kicks to either side, while the board only listens.",
            .reads = {},
            .makes = {"hand.ulg", "record.json"},
            .commands = {Command{"m100", "record"} + at_port() + at_pose() + with_key() +
                         Command{"--log", "hand.ulg", "--hold", "150", "--json", "record.json"}},
            .judge = [](Folder& folder) { return judge_recording(folder, "record.json"); }};
  }
  static Command identify(const char* axis, const char* log, const char* map, const char* vehicle,
                          const std::string& name) {
    return {"m100-lab",  "identify",     "--log",    log,           "--columns", map,  "--axis",    axis,
            "--declare", kDeclared,      "--split",  "alternate:6", "--draws",   "40", "--vehicle", vehicle,
            "--json",    name + ".json", "--report", name};
  }
  Step identify() const {
    return {.name = "identify",
            .sentence = "Find the model of roll and pitch in the log that was flown by hand.",
            .reads = {"hand.ulg", "columns_hand.toml", "first_vehicle.toml"},
            .makes = {"identified.toml", "hand_roll.json", "hand_pitch.json"},
            .commands = {{"copy", "first_vehicle.toml", "identified.toml"},
                         identify("roll", "hand.ulg", "columns_hand.toml", "identified.toml", "hand_roll"),
                         identify("pitch", "hand.ulg", "columns_hand.toml", "identified.toml", "hand_pitch")},
            .judge = [](Folder& folder) {
              return judge_identification(folder, {"hand_roll.json", "hand_pitch.json"}, "before");
            }};
  }
  Step gains() const {
    const Command tables{"m100-lab", "gains", "--table", "vehicle.gains", "--json", "vehicle_margins.json"};
    std::vector<Command> commands{tables + Command{"--vehicle", "identified.toml", "--tune", "vehicle.toml"}};
    if (folder_.numbers().contains(kCalmer) || folder_.numbers().contains(kBalanced)) {
      commands.push_back({"adjust", "vehicle.toml"});
      commands.push_back(tables + Command{"--vehicle", "vehicle.toml"});
    }
    return {.name = "gains",
            .sentence = "Choose the weights and make the controller's tables from identified.toml.",
            .reads = {"identified.toml"},
            .makes = {"vehicle.toml", "vehicle.gains", "vehicle_margins.json"},
            .commands = commands,
            .judge = [](Folder& folder) { return judge_margins(folder, "vehicle_margins.json"); }};
  }
  /// The weights stay as they flew: what the correction is worth is seen only where nothing else changes.
  static Step gains_again() {
    return {.name = "gains_again",
            .sentence = "Make the controller's tables from corrected.toml, with the weights that flew.",
            .reads = {"corrected.toml"},
            .makes = {"corrected.gains", "corrected_margins.json"},
            .commands = {{"m100-lab", "gains", "--vehicle", "corrected.toml", "--table", "corrected.gains", "--json",
                          "corrected_margins.json"}},
            .judge = [](Folder& folder) { return judge_margins(folder, "corrected_margins.json"); }};
  }
  static Step check(const std::string& name, const std::string& of) {
    return {.name = name,
            .sentence = "See whether vehicle file, tables, flight file and course agree.",
            .reads = {of + ".toml", of + ".gains", "flight.toml", "course.txt"},
            .makes = {name + ".txt"},
            .commands = {{"m100", "check", "--vehicle", of + ".toml", "--gains", of + ".gains", "--flight",
                          "flight.toml", "--course", "course.txt"}},
            .judge = [](Folder&) { return std::string(); }};
  }
  Step handshake() const {
    return {.name = "handshake",
            .on_board = true,
            .sentence =
                "On the bench, propellers OFF, mode switch at F: take control, hold it for five seconds, give it back.",
            .reads = {},
            .makes = {"handshake.json"},
            .commands = {Command{"m100", "handshake"} + at_port() + as_app() + Command{"--json", "handshake.json"}},
            .judge = [](Folder& folder) { return judge_handshake(folder, "handshake.json"); }};
  }
  Command fly(const std::string& vehicle, const std::string& name, const Command& more) const {
    return Command{"m100", "fly"} + at_port() + at_pose() + as_app() +
           Command{"--vehicle", vehicle + ".toml", "--gains",        vehicle + ".gains",
                   "--flight",  "flight.toml",     "--take-control", "--once"} +
           more + Command{"--log", name + ".ulg", "--json", name + ".json"};
  }
  Step hover() const {
    return {.name = "hover",
            .on_board = true,
            .sentence =
                "Take off by hand to the middle of the fence, switch to F, start this, and keep a thumb at the mode "
                "switch: twenty seconds of hovering.",
            .reads = {"vehicle.toml", "vehicle.gains", "flight.toml"},
            .makes = {"hover.ulg", "hover.json"},
            .commands = {fly("vehicle", "hover", {"--hold", "20"})},
            .judge = [](Folder& folder) { return judge_hover(folder, "hover"); }};
  }
  Step course(const std::string& name, const std::string& vehicle, const std::string& sentence) const {
    return {.name = name,
            .on_board = true,
            .sentence = sentence,
            .reads = {vehicle + ".toml", vehicle + ".gains", "flight.toml", "course.txt"},
            .makes = {name + ".ulg", name + ".json"},
            .commands = {fly(vehicle, name, {"--hold", "40", "--course", "course.txt"})},
            .judge = [name, file = vehicle + ".toml"](Folder& folder) { return judge_course(folder, name, file); }};
  }
  Step plan() const {
    return {.name = "plan",
            .sentence = "Make stick movements that fit into the fence and tell the effects apart.",
            .reads = {"vehicle.toml", "flight.toml"},
            .makes = {"sticks.csv", "forecast.json"},
            .commands = {{"m100-lab", "excite", "--axis", "roll,pitch", "--duration", "40", "--amplitude", "150",
                          "--fence", text(kShareOfFence * least_side_m(folder_)), "--vehicle", "vehicle.toml", "--out",
                          "sticks.csv", "--json", "forecast.json"}},
            .judge = [](Folder&) { return std::string(); }};
  }
  Step excite() const {
    return {.name = "excite",
            .on_board = true,
            .sentence = "In the middle of the fence: the board moves roll, then pitch, and comes back by itself.",
            .reads = {"vehicle.toml", "vehicle.gains", "flight.toml", "sticks.csv"},
            .makes = {"excite.ulg", "excite.json"},
            .commands = {fly("vehicle", "excite", {"--hold", "5", "--excite", "sticks.csv"})},
            .judge = [](Folder& folder) { return judge_excitation(folder, "excite.json"); }};
  }
  Step identify_again() const {
    const Command more{"--within",      excited(folder_),     "--forecast",
                       "forecast.json", "--vehicle-believed", "vehicle.toml"};
    return {
        .name = "identify_again",
        .sentence = "Find in the excited flight what the first vehicle file lacks.",
        .reads = {"excite.ulg", "excite.json", "columns_flight.toml", "forecast.json", "vehicle.toml"},
        .makes = {"corrected.toml", "flown_roll.json", "flown_pitch.json"},
        .commands = {{"copy", "vehicle.toml", "corrected.toml"},
                     identify("roll", "excite.ulg", "columns_flight.toml", "corrected.toml", "flown_roll") + more,
                     identify("pitch", "excite.ulg", "columns_flight.toml", "corrected.toml", "flown_pitch") + more},
        .judge = [](Folder& folder) {
          return judge_identification(folder, {"flown_roll.json", "flown_pitch.json"}, "after");
        }};
  }

  const Folder& folder_;
  const Settings& settings_;
};

void put(const Folder& folder, const std::string& name, std::string_view bytes) {
  if (folder.has(name)) {
    return;
  }
  std::ofstream out(folder.file(name), std::ios::binary);
  out << bytes;
  if (!out.flush()) {
    throw InputError(folder.file(name), 0, "", "cannot be written");
  }
}

}  // namespace

void adjust(const Folder& folder, const std::string& vehicle) {
  companion::VehicleFile file = companion::load_vehicle(folder.file(vehicle));
  const std::map<std::string, double>& numbers = folder.numbers();
  if (numbers.contains(kCalmer)) {
    file.vehicle.mpc.input *= std::pow(kCalmerFactor, numbers.at(kCalmer));
  }
  if (numbers.contains(kBalanced)) {
    file.vehicle.roll.trim_counts = numbers.at(kBalanceRoll);
    file.vehicle.pitch.trim_counts = numbers.at(kBalancePitch);
  }
  companion::save_vehicle(folder.file(vehicle), file.vehicle, file.sources);
}

std::vector<Step> steps(const Folder& folder) { return Maker(folder).all(); }

void lay_out(const Folder& folder) {
  put(folder, "flight.toml", kFlightFile);
  put(folder, "course.txt", kCourse);
  put(folder, "columns_hand.toml", kHandMap);
  put(folder, "columns_flight.toml", kFlightMap);
  put(folder, "first_vehicle.toml", companion::to_text(mpc::generated::kVehicle, {}));
}

}  // namespace m100::lab::evening
