// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/evening/judge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "firmware/companion/files/vehicle_file.h"
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

/// What a flight log says of the reference, beside the signals.
constexpr std::string_view kTrackingMap = R"(time = "tick.timestamp"
[signals]
position_x = "tick.pose_position[0]"
position_y = "tick.pose_position[1]"
position_z = "tick.pose_position[2]"
[extra]
x = "tick.ref_position[0]"
y = "tick.ref_position[1]"
z = "tick.ref_position[2]"
)";

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

std::string judge_course(Folder& folder, const std::string& name, const std::string& vehicle) {
  const std::string result = name + ".json";
  const std::string log = name + ".ulg";
  if (const std::string why = judge_flight(folder, result); !why.empty()) {
    return why;
  }
  const std::pair<double, double> flown = nominal(result_of(folder, result));
  const logs::FlightLog flight =
      logs::load(*logs::open_log(folder.file(log)), logs::parse_column_map(kTrackingMap, "(reference and pose)"));
  // x and y of the logged reference are those that a command of the tick is for: ahead of it by the delay that the law
  // predicts through (ref::Window). Height is that of the tick.
  const double delay_s = companion::load_vehicle(folder.file(vehicle)).vehicle.pitch.transport_delay_s;
  const double ahead = std::clamp(delay_s, 0.0, kMostDelay_s) / flight.period_s;
  const auto reference_at = [&](const char* axis, std::size_t k, double ticks) {
    const auto whole = static_cast<std::size_t>(ticks);
    const double share = ticks - static_cast<double>(whole);
    const std::vector<double>& at = flight.extra.at(axis);
    return (1.0 - share) * at[k - whole] + share * at[k - whole - 1];
  };
  double sum_m2 = 0.0;
  std::size_t count = 0;
  const std::size_t first = static_cast<std::size_t>(ahead) + 1;
  for (std::size_t k = std::max(first, flight.index_of(flown.first + kSettled_s)); k < flight.index_of(flown.second);
       ++k) {
    const double x_m = flight.of(logs::Signal::kPositionX)[k] - reference_at("x", k, ahead);
    const double y_m = flight.of(logs::Signal::kPositionY)[k] - reference_at("y", k, ahead);
    const double z_m = flight.of(logs::Signal::kPositionZ)[k] - reference_at("z", k, 0.0);
    sum_m2 += x_m * x_m + y_m * y_m + z_m * z_m;
    ++count;
  }
  if (count == 0) {
    return log + ": holds no second of a flight under control";
  }
  folder.note("pose_m." + name, std::sqrt(sum_m2 / static_cast<double>(count)));
  return "";
}

std::string judge_excitation(const Folder& folder, const std::string& result) {
  const json said = result_of(folder, result);
  if (!said.contains("excitation")) {
    return judge_flight(folder, result);
  }
  if (said["excitation"].value("over", false)) {
    return judge_flight(folder, result);
  }
  return "the excitation was not flown to its end: " +
         said["excitation"].value("abort", json::object()).value("why", "control was lost");
}

}  // namespace m100::lab::evening
