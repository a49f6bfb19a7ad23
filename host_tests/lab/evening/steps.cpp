// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/evening/steps.h"

#include <algorithm>
#include <utility>

#include "firmware/companion/files/flight_file.h"
#include "firmware/companion/files/text/json.h"
#include "host_tests/lab/evening/flight_result.h"
#include "host_tests/lab/evening/step_checks.h"
#include "host_tests/lab/printed.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab::evening {
namespace {

/// The declared structure of roll and pitch. Every M100 has a stick trim (paper, III-A), so the trim is declared: an
/// undeclared trim can be identified as a dead zone.
constexpr const char* kDeclared = "second_order,transport_delay,dead_zone,trim_offset";
/// The delay of the serial line and of the sampling is too short to be found in a log. Undeclared, it would change the
/// frequency of climb and the time constant of yaw.
constexpr const char* kDeclaredClimb = "second_order,transport_delay,dead_zone,trim_offset";
/// In the measured flight, yaw has a stick curve: it leaves an error of 0.036 rad/s, a dead zone leaves 0.039.
constexpr const char* kDeclaredYaw = "first_order,transport_delay,stick_curve,trim_offset";
constexpr double kMinHeight_m = 0.5;   ///< an excitation's way up and down: less does not show the throttle
constexpr double kMaxHeight_m = 0.8;   ///< an excitation's way up and down: more is not needed
constexpr double kYawFence_rad = 1.0;  ///< for an excitation of yaw alone, in a room too low to move the throttle
constexpr double kShareOfFence = 0.6;  ///< that an excitation uses; the rest is a margin for unforeseen tilt

std::string text(double value) { return printed("%g", value); }

Command operator+(Command left, const Command& right) {
  left.insert(left.end(), right.begin(), right.end());
  return left;
}

companion::FlightFile flight_file(const Folder& folder) {
  return companion::parse_flight(whole_file(folder.file("flight.toml")), folder.file("flight.toml"));
}

/// The horizontal distance from the start to the nearest side of the flight file's fence.
double min_side_m(const Folder& folder) {
  const companion::FlightFile flight = flight_file(folder);
  return std::min({-flight.fence_x_m.low, flight.fence_x_m.high, -flight.fence_y_m.low, flight.fence_y_m.high});
}

/// The largest height change of an excitation from the middle of the fence; 0: the room is too low for one.
double height_m(const Folder& folder) {
  const companion::FlightFile flight = flight_file(folder);
  const double most_m = kShareOfFence * 0.5 * (flight.fence_z_m.high - flight.fence_z_m.low);
  return most_m < kMinHeight_m ? 0.0 : std::min(most_m, kMaxHeight_m);
}

/// "FROM:TO" on the log's clock; empty: it was not flown yet.
std::string from_to(const std::pair<double, double>& range) {
  return range.first < range.second ? text(range.first) + ":" + text(range.second) : "";
}

/// from_to() of the time in which the law commanded: before it the observer's velocities have not converged.
std::string commanded(const Folder& folder, const std::string& name) {
  return folder.has(name + ".json") ? from_to(nominal(result_of(folder, name + ".json"))) : "";
}

ctl::ExcitedStick stick_of(const std::string& axis) {
  using Stick = ctl::ExcitedStick;
  return axis == "roll"    ? Stick::kRoll
         : axis == "pitch" ? Stick::kPitch
         : axis == "climb" ? Stick::kThrottle
                           : Stick::kYaw;
}

/// Makes the steps of one folder.
class StepBuilder {
 public:
  explicit StepBuilder(const Folder& folder) : folder_(folder), settings_(folder.settings()) {}

  std::vector<Step> all() const {
    std::vector<Step> out{probe(), record()};
    for (Step& step : std::vector{identify(), gains(), check("check", "vehicle")}) {
      out.push_back(std::move(step));
    }
    out.push_back(handshake());
    out.push_back(hover());
    courses(out, kBefore, "vehicle", "Fly the course with the first vehicle file: the error before.");
    out.push_back(plan());
    out.push_back(excite());
    out.push_back(excite_rates());
    out.push_back(identify_again());
    out.push_back(identify_rates());
    out.push_back(gains_again());
    out.push_back(check("check_again", "corrected"));
    courses(out, kAfter, "corrected", "Fly the same course with the corrected vehicle file: the error after.");
    return out;
  }

 private:
  Command at_port() const { return {"--port", settings_.port, "--baud", std::to_string(settings_.baud)}; }
  Command at_pose() const { return companion::words_of(settings_.pose); }
  Command with_key() const {
    return settings_.key_file.empty() ? Command{} : Command{"--key-file", settings_.key_file};
  }
  Command as_app() const {
    return (settings_.app_id == 0 ? Command{} : Command{"--app-id", std::to_string(settings_.app_id)}) + with_key();
  }

  Step probe() const {
    return {.name = "probe",
            .on_board = true,
            .sentence = "Switch the aircraft on, propellers off, and let the board listen: does the autopilot answer?",
            .reads = {},
            .makes = {"probe.json"},
            .commands = {Command{"m100", "probe"} + at_port() + Command{"--json", "probe.json"}},
            .evaluate = [](Folder& folder) { return check_probe(folder, "probe.json"); }};
  }
  Step record() const {
    return {.name = "record",
            .on_board = true,
            .sentence =
                "Fly by hand in mode P for two minutes, inside the space, and move roll, then pitch, in short pairs of "
                "kicks to either side, by a tenth to a quarter of the stick, while the board only listens.",
            .reads = {},
            .makes = {"hand.ulg", "record.json"},
            .commands = {Command{"m100", "record"} + at_port() + at_pose() + with_key() +
                         Command{"--log", "hand.ulg", "--hold", "150", "--json", "record.json"}},
            .evaluate = [](Folder& folder) { return check_recording(folder, "record.json"); }};
  }
  static Command identify(const char* axis, const char* log, const char* map, const char* vehicle,
                          const std::string& name, const char* declared = kDeclared) {
    return {"m100-lab",  "identify",     "--log",    log,           "--columns", map,  "--axis",    axis,
            "--declare", declared,       "--split",  "alternate:6", "--draws",   "40", "--vehicle", vehicle,
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
            .evaluate = [](Folder& folder) {
              return check_identification(folder, {"hand_roll.json", "hand_pitch.json"}, "before");
            }};
  }
  Step gains() const {
    const Command tables{"m100-lab", "gains", "--table", "vehicle.gains", "--json", "vehicle_margins.json"};
    std::vector<Command> commands{tables + Command{"--vehicle", "identified.toml", "--tune", "vehicle.toml"}};
    if (folder_.numbers().contains(kWeightIncreases) || folder_.numbers().contains(kTrimmed)) {
      commands.push_back({"adjust", "vehicle.toml"});
      commands.push_back(tables + Command{"--vehicle", "vehicle.toml"});
    }
    return {.name = "gains",
            .sentence = "Choose the weights and make the controller's tables from identified.toml.",
            .reads = {"identified.toml"},
            .makes = {"vehicle.toml", "vehicle.gains", "vehicle_margins.json"},
            .commands = commands,
            .evaluate = [](Folder& folder) { return check_margins(folder, "vehicle_margins.json"); }};
  }
  /// Tunes the corrected law by the same command as the first one. compare_laws() replaces it where it flies worse.
  static Step gains_again() {
    return {
        .name = "gains_again",
        .sentence = "Choose the weights for the corrected model, compare both laws, and make the tables of the better.",
        .reads = {"corrected_model.toml", "vehicle.toml", "course.txt"},
        .makes = {"corrected.toml", "corrected.gains", "corrected_margins.json"},
        .commands = {{"m100-lab", "gains", "--vehicle", "corrected_model.toml", "--present", "vehicle.toml", "--tune",
                      "corrected.toml"},
                     {"compare_laws"},
                     {"m100-lab", "gains", "--vehicle", "corrected.toml", "--table", "corrected.gains", "--json",
                      "corrected_margins.json"}},
        .evaluate = [](Folder& folder) { return check_margins(folder, "corrected_margins.json"); }};
  }
  static Step check(const std::string& name, const std::string& of) {
    return {.name = name,
            .sentence = "Check that vehicle file, tables, flight file and course agree.",
            .reads = {of + ".toml", of + ".gains", "flight.toml", "course.txt"},
            .makes = {name + ".txt"},
            .commands = {{"m100", "check", "--vehicle", of + ".toml", "--gains", of + ".gains", "--flight",
                          "flight.toml", "--course", "course.txt"}},
            .evaluate = [](Folder&) { return std::string(); }};
  }
  Step handshake() const {
    return {.name = "handshake",
            .on_board = true,
            .sentence =
                "On the bench, propellers OFF, mode switch at F: take control, hold it for five seconds, give it back.",
            .reads = {},
            .makes = {"handshake.json"},
            .commands = {Command{"m100", "handshake"} + at_port() + as_app() + Command{"--json", "handshake.json"}},
            .evaluate = [](Folder& folder) { return check_handshake(folder, "handshake.json"); }};
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
            .evaluate = [](Folder& folder) { return check_hover(folder, "hover"); }};
  }
  /// The course, as often as the settings say: NAME, NAME_2, ...
  void courses(std::vector<Step>& out, const std::string& name, const std::string& vehicle,
               const std::string& sentence) const {
    for (int flight = 1; flight <= settings_.flights; ++flight) {
      out.push_back(course(flight == 1 ? name : name + "_" + std::to_string(flight), vehicle, sentence));
    }
  }
  Step course(const std::string& name, const std::string& vehicle, const std::string& sentence) const {
    return {.name = name,
            .on_board = true,
            .sentence = sentence,
            .reads = {vehicle + ".toml", vehicle + ".gains", "flight.toml", "course.txt"},
            .makes = {name + ".ulg", name + ".json"},
            .commands = {fly(vehicle, name, {"--hold", "40", "--course", "course.txt"})},
            .evaluate = [name](Folder& folder) { return check_course(folder, name); }};
  }
  static Command plan(const std::string& axes, double fence, const std::string& sticks, const std::string& forecast) {
    return {"m100-lab", "excite",    "--axis",    axes,           "--duration", "40",   "--amplitude", "150",
            "--fence",  text(fence), "--vehicle", "vehicle.toml", "--out",      sticks, "--json",      forecast};
  }
  Step plan() const {
    const double height = height_m(folder_);
    return {
        .name = "plan",
        .sentence = "Make stick movements that fit into the fence and tell the effects apart.",
        .reads = {"vehicle.toml", "flight.toml"},
        .makes = {"sticks.csv", "forecast.json", "sticks_rates.csv", "forecast_rates.json"},
        // "try": even if no effect of climb or yaw rate would be found, the movement shows the channel's own numbers.
        .commands = {plan("roll,pitch", kShareOfFence * min_side_m(folder_), "sticks.csv", "forecast.json"),
                     Command{"try"} +
                         (height > 0.0 ? plan("climb,yaw_rate", height, "sticks_rates.csv", "forecast_rates.json")
                                       : plan("yaw_rate", kYawFence_rad, "sticks_rates.csv", "forecast_rates.json"))},
        .evaluate = [](Folder&) { return std::string(); }};
  }
  Step excite() const {
    return {.name = "excite",
            .on_board = true,
            .sentence = "In the middle of the fence: the board moves roll, then pitch, and comes back by itself.",
            .reads = {"vehicle.toml", "vehicle.gains", "flight.toml", "sticks.csv"},
            .makes = {"excite.ulg", "excite.json"},
            .commands = {fly("vehicle", "excite", {"--hold", "5", "--excite", "sticks.csv"})},
            .evaluate = [](Folder& folder) { return check_excitation(folder, "excite.json"); }};
  }
  Step excite_rates() const {
    return {.name = "excite_rates",
            .on_board = true,
            .sentence = "In the middle of the fence, in height too: the board moves throttle and yaw, and comes back.",
            .reads = {"vehicle.toml", "vehicle.gains", "flight.toml", "sticks_rates.csv"},
            .makes = {"excite_rates.ulg", "excite_rates.json"},
            .commands = {fly("vehicle", "excite_rates", {"--hold", "5", "--excite", "sticks_rates.csv"})},
            .evaluate = [](Folder& folder) { return check_rates_excitation(folder, "excite_rates.json"); }};
  }
  Command again(const char* axis, const std::string& flight, const char* forecast, const char* vehicle,
                const char* declared) const {
    const char* columns = std::string_view(axis) == "climb" ? "columns_climb.toml" : "columns_flight.toml";
    return identify(axis, (flight + ".ulg").c_str(), columns, vehicle, std::string("flown_") + axis, declared) +
           Command{"--within",           from_to(moved(folder_, flight, stick_of(axis))),
                   "--forecast",         forecast,
                   "--vehicle-believed", "vehicle.toml"};
  }
  Step identify_again() const {
    return {.name = "identify_again",
            .sentence = "Identify roll, pitch and drag from the excited flight, to correct the first vehicle file.",
            .reads = {"excite.ulg", "excite.json", "columns_flight.toml", "columns_climb.toml", "forecast.json",
                      "vehicle.toml"},
            .makes = {"tilts.toml", "flown_roll.json", "flown_pitch.json"},
            .commands = {{"copy", "vehicle.toml", "tilts.toml"},
                         again("roll", "excite", "forecast.json", "tilts.toml", kDeclared),
                         again("pitch", "excite", "forecast.json", "tilts.toml", kDeclared),
                         {"copy", "vehicle.toml", "drag.toml"},
                         Command{"try"} +
                             identify("translation", "excite.ulg", "columns_climb.toml", "drag.toml",
                                      "flown_translation", "rigid_body") +
                             Command{"--within", commanded(folder_, "excite")}},
            .evaluate = [](Folder& folder) {
              return check_identification(folder, {"flown_roll.json", "flown_pitch.json"}, "after");
            }};
  }
  /// Identifies climb and yaw rate. A channel that is not found, or predicts no better, keeps its old model.
  Step identify_rates() const {
    std::vector<Command> commands{{"copy", "vehicle.toml", "rates.toml"}};
    if (folder_.number(kRatesNotFlown) < 2.0) {
      if (height_m(folder_) > 0.0) {
        commands.push_back(Command{"try"} +
                           again("climb", "excite_rates", "forecast_rates.json", "rates.toml", kDeclaredClimb));
      }
      commands.push_back(Command{"try"} +
                         again("yaw_rate", "excite_rates", "forecast_rates.json", "rates.toml", kDeclaredYaw));
    }
    commands.push_back({"take_over"});
    return {.name = "identify_rates",
            .sentence =
                "Identify climb and yaw rate, and keep a model that predicts the flight better than the first vehicle "
                "file.",
            .reads = {"excite_rates.ulg", "excite_rates.json", "columns_flight.toml", "columns_climb.toml",
                      "forecast_rates.json", "vehicle.toml", "tilts.toml", "course.ulg", "course.json", "course.txt"},
            .makes = {"rates.toml", "corrected_model.toml"},
            .commands = commands,
            .evaluate = [](Folder&) { return std::string(); }};
  }

  const Folder& folder_;
  const Settings& settings_;
};

}  // namespace

std::vector<Step> steps(const Folder& folder) { return StepBuilder(folder).all(); }

}  // namespace m100::lab::evening
