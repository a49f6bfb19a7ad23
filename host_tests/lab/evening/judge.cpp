// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/evening/judge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "firmware/companion/files/vehicle_file.h"
#include "host_tests/lab/campaign/oscillation.h"
#include "host_tests/lab/evening/steps.h"
#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/lab/logs/raw_log.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab::evening {
namespace {

using nlohmann::json;

constexpr double kLeastMoved_counts = 60.0;  ///< to either side, of roll and pitch: less is noise to a fit
constexpr double kWorstFit_percent = 50.0;   ///< of the validation part; below, the log does not show the axis
constexpr double kMostDelay_s = 0.5;         ///< of an axis
constexpr double kSettled_s = 1.0;           ///< after control begins, before errors count
constexpr double kBalanced_s = 5.0;          ///< after control begins, before the mean stick is a trim
constexpr double kMostCalmer = 2.0;          ///< times that the weights are made calmer before the evening gives up

/// What a flight log says of the reference, beside the signals.
constexpr std::string_view kTrackingMap = R"(time = "tick.timestamp"
[signals]
stick_roll = { column = "tick.sticks[0]", offset = -1024 }
stick_pitch = { column = "tick.sticks[1]", offset = -1024 }
attitude_roll = "tick.imu_attitude[0]"
attitude_pitch = "tick.imu_attitude[1]"
position_x = "tick.pose_position[0]"
position_y = "tick.pose_position[1]"
position_z = "tick.pose_position[2]"
[extra]
x = "tick.ref_position[0]"
y = "tick.ref_position[1]"
z = "tick.ref_position[2]"
age = "tick.pose_age"
)";

logs::FlightLog tracked(const Folder& folder, const std::string& log) {
  return logs::load(*logs::open_log(folder.file(log)),
                    logs::parse_column_map(kTrackingMap, "(reference, pose and tilt)"));
}

json result_of(const Folder& folder, const std::string& result) {
  const json read = json::parse(whole_file(folder.file(result)), nullptr, false);
  return read.is_object() ? read : json::object();
}

std::string rounded(double value) {
  std::ostringstream out;
  out.precision(3);
  out << value;
  return out.str();
}

/// Seconds on the log's clock during which the law commanded.
std::pair<double, double> nominal(const json& result) {
  std::pair<double, double> out{0.0, 0.0};
  for (const json& step : result.value("ladder", json::array())) {
    if (step.value("to", "") == "nominal" && out.first == 0.0) {
      out.first = step.value("t_s", 0.0);
    } else if (step.value("from", "") == "nominal") {
      out.second = step.value("t_s", 0.0);
    }
  }
  return out;
}

}  // namespace

std::string judge_probe(const Folder& folder, const std::string& result) {
  const json said = result_of(folder, result);
  const std::string verdict = said.value("verdict", "");
  return verdict == "autopilot"
             ? ""
             : "the board heard '" + verdict + "' instead of an autopilot: " + said.value("remedy", "");
}

std::string judge_recording(const Folder& folder, const std::string& result) {
  const json said = result_of(folder, result);
  if (!said.value("recorded", false)) {
    return "nothing useful was recorded: " + said.value("trouble", "no reason given");
  }
  for (const char* const stick : {"roll", "pitch"}) {
    const json& moved = said["sticks"][stick];
    if (moved.value("most_counts", 0.0) < kLeastMoved_counts ||
        moved.value("least_counts", 0.0) > -kLeastMoved_counts) {
      return std::string("the ") + stick + " stick moved from " + rounded(moved.value("least_counts", 0.0)) + " to " +
             rounded(moved.value("most_counts", 0.0)) + " counts: move it by " + rounded(kLeastMoved_counts) +
             " at least, to both sides";
    }
  }
  return "";
}

std::string judge_identification(Folder& folder, const std::vector<std::string>& answers, const std::string& name) {
  for (const std::string& answer : answers) {
    const json said = result_of(folder, answer);
    const double fit = said["final"].value("fit_percent", 0.0);
    const std::string axis = said.value("axis", answer);
    if (fit < kWorstFit_percent) {
      return axis + ": the model explains only " + rounded(fit) + " % of the part of the log that it has not seen, " +
             rounded(kWorstFit_percent) + " % are needed; excite the axis more, or see " + answer;
    }
    folder.note("rmse_rad." + axis + "." + name, said["final"].value("validation_rmse", 0.0));
    const std::array<std::pair<const char*, const char*>, 2> kept{
        {{"delay_s", "transport_delay_s"}, {"offset_counts", "trim_counts"}}};
    for (const auto& [parameter, key] : kept) {
      folder.note(std::string(key) + "." + axis + "." + name, said["final"]["parameters"].value(parameter, 0.0));
    }
  }
  return "";
}

std::string judge_margins(const Folder& folder, const std::string& result) {
  const json said = result_of(folder, result);
  for (const char* const axis : {"x", "y"}) {
    if (!said["margins"][axis].value("stable", false)) {
      return std::string("the loop of axis ") + axis + " is not stable with these weights; see " + result;
    }
  }
  return "";
}

std::string judge_handshake(const Folder& folder, const std::string& result) {
  const json said = result_of(folder, result);
  return said.value("obtained", false) && said.value("released", false)
             ? ""
             : "control was " + std::string(said.value("obtained", false) ? "not given back" : "not obtained") +
                   "; the autopilot's last word: " + said.value("last_reason", "none");
}

std::string judge_flight(const Folder& folder, const std::string& result) {
  const json said = result_of(folder, result);
  if (!said.value("obtained", false) || !said.value("released", false)) {
    return judge_handshake(folder, result);
  }
  for (const json& step : said.value("ladder", json::array())) {
    const std::string cause = step.value("cause", "");
    if (cause == "given_back") {
      break;  // what follows is how control goes back
    }
    if (cause != "engaged") {
      return "the flight left its normal course: " + step.value("from", "") + " to " + step.value("to", "") + ", " +
             step.value("seen", "");
    }
  }
  return "";
}

namespace {

/// The loop is too fast for the delay that the aircraft really has. @returns what is done about it.
std::string calmer(Folder& folder, const std::string& seen) {
  const auto before = folder.numbers().find(kCalmer);
  const double times = before == folder.numbers().end() ? 0.0 : before->second;
  if (times >= kMostCalmer) {
    return seen + ", and no weights calm it. Look at the delays in the log, and record by hand anew";
  }
  folder.note(kCalmer, times + 1.0);
  folder.again("gains");
  return seen + ": its delay is longer than the vehicle file's. The weights become calmer; then hover again";
}

/// The mean stick of a hover, where it has settled: what balances the aircraft as it is now.
void note_balance(Folder& folder, const logs::FlightLog& flight, std::pair<double, double> flown) {
  const std::size_t first = flight.index_of(flown.first + kBalanced_s);
  const std::size_t last = flight.index_of(flown.second);
  for (const auto& [signal, name] :
       {std::pair{logs::Signal::kStickRoll, kBalanceRoll}, std::pair{logs::Signal::kStickPitch, kBalancePitch}}) {
    double sum = 0.0;
    for (std::size_t k = first; k < last; ++k) {
      sum += flight.of(signal)[k];
    }
    if (last > first) {
      folder.note(name, sum / static_cast<double>(last - first));
    }
  }
}

}  // namespace

std::string judge_hover(Folder& folder, const std::string& name) {
  const std::string result = name + ".json";
  if (const std::string why = judge_flight(folder, result); !why.empty()) {
    return why;
  }
  const std::pair<double, double> flown = nominal(result_of(folder, result));
  const logs::FlightLog flight = tracked(folder, name + ".ulg");
  experiments::Trace trace;
  for (std::size_t k = flight.index_of(flown.first + kSettled_s); k < flight.index_of(flown.second); ++k) {
    trace.push_back({.roll_rad = flight.of(logs::Signal::kAttitudeRoll)[k],
                     .pitch_rad = flight.of(logs::Signal::kAttitudePitch)[k]});
  }
  const campaign::Swing swing = campaign::swing_of(trace);
  const double most_deg = std::max(swing.roll_deviation_deg, swing.pitch_deviation_deg);
  folder.note("swing_deg." + name, most_deg);
  note_balance(folder, flight, flown);
  if (!swing.periodic && !result_of(folder, result).contains("swinging")) {
    return "";
  }
  return calmer(folder, "the aircraft swings by itself, " + rounded(most_deg) + " degrees root mean square");
}

std::string judge_course(Folder& folder, const std::string& name, const std::string& vehicle) {
  const std::string result = name + ".json";
  const std::string log = name + ".ulg";
  if (const std::string why = judge_flight(folder, result); !why.empty()) {
    return why;
  }
  const std::pair<double, double> flown = nominal(result_of(folder, result));
  const logs::FlightLog flight = tracked(folder, log);
  // x and y of the logged reference are those that a command of the tick is for: ahead of it by the delay that the law
  // predicts through (ref::Window). Height is that of the tick. The pose is where the aircraft was at its capture.
  const double delay_s = companion::load_vehicle(folder.file(vehicle)).vehicle.pitch.transport_delay_s;
  const double ahead = std::clamp(delay_s, 0.0, kMostDelay_s) / flight.period_s;
  const auto reference_at = [&](const char* axis, std::size_t k, double ticks) {
    const auto whole = static_cast<std::size_t>(ticks);
    const double share = ticks - static_cast<double>(whole);
    const std::vector<double>& at = flight.extra.at(axis);
    return (1.0 - share) * at[k - whole] + share * at[k - whole - 1];
  };
  double horizontal_m2 = 0.0;
  double height_m2 = 0.0;
  double count = 0.0;
  const auto first = static_cast<std::size_t>(ahead + kMostDelay_s / flight.period_s) + 1;
  for (std::size_t k = std::max(first, flight.index_of(flown.first + kSettled_s)); k < flight.index_of(flown.second);
       ++k) {
    const double age = std::clamp(flight.extra.at("age")[k], 0.0, kMostDelay_s) / flight.period_s;
    const double x_m = flight.of(logs::Signal::kPositionX)[k] - reference_at("x", k, ahead + age);
    const double y_m = flight.of(logs::Signal::kPositionY)[k] - reference_at("y", k, ahead + age);
    const double z_m = flight.of(logs::Signal::kPositionZ)[k] - reference_at("z", k, age);
    horizontal_m2 += x_m * x_m + y_m * y_m;
    height_m2 += z_m * z_m;
    count += 1.0;
  }
  if (count == 0.0) {
    return log + ": holds no second of a flight under control";
  }
  folder.note("pose_m." + name, std::sqrt((horizontal_m2 + height_m2) / count));
  folder.note("horizontal_m." + name, std::sqrt(horizontal_m2 / count));
  folder.note("height_m." + name, std::sqrt(height_m2 / count));
  return "";
}

std::string judge_excitation(Folder& folder, const std::string& result) {
  const json said = result_of(folder, result);
  if (!said.contains("excitation") || said["excitation"].value("over", false)) {
    return judge_flight(folder, result);
  }
  const std::string why = said["excitation"].value("abort", json::object()).value("why", "control was lost");
  const std::string seen = "the excitation was not flown to its end (" + why + ")";
  if (why == "not_at_rest") {
    return calmer(folder, seen);
  }
  if (why == "control was lost" || why == "ladder" || folder.numbers().contains(kBalanced)) {
    return seen;
  }
  folder.note(kBalanced, 1.0);
  folder.again("gains");
  return seen + ": the trims become those that the hover flew with; then hover again";
}

}  // namespace m100::lab::evening
