// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/evening/judge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "host_tests/lab/campaign/oscillation.h"
#include "host_tests/lab/evening/flown.h"
#include "host_tests/lab/evening/steps.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::evening {
namespace {

using nlohmann::json;

constexpr double kLeastMoved_counts = 60.0;  ///< to either side, for roll and pitch: a fit cannot tell less from noise
constexpr double kWorstFit_percent = 50.0;   ///< on the validation part; below it the log does not show the axis
constexpr double kBalanced_s = 5.0;          ///< from the start of control until the mean stick is taken as the trim
constexpr double kMostCalmer = 2.0;          ///< how often the weights are made calmer before the evening gives up

std::string rounded(double value) {
  std::ostringstream out;
  out.precision(3);
  out << value;
  return out.str();
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
    const json& moved = said.at("sticks").at(stick);
    if (moved.value("most_counts", 0.0) < kLeastMoved_counts ||
        moved.value("least_counts", 0.0) > -kLeastMoved_counts) {
      return std::string("the ") + stick + " stick moved from " + rounded(moved.value("least_counts", 0.0)) + " to " +
             rounded(moved.value("most_counts", 0.0)) + " counts: move it by at least " + rounded(kLeastMoved_counts) +
             " counts to both sides";
    }
  }
  return "";
}

std::string judge_identification(Folder& folder, const std::vector<std::string>& answers, const std::string& name) {
  for (const std::string& answer : answers) {
    const json said = result_of(folder, answer);
    const double fit = said.at("final").value("fit_percent", 0.0);
    const std::string axis = said.value("axis", answer);
    if (fit < kWorstFit_percent) {
      return axis + ": the model explains only " + rounded(fit) + " % of the validation part of the log; at least " +
             rounded(kWorstFit_percent) + " % is needed. Excite the axis more, or see " + answer;
    }
    folder.note("rmse_rad." + axis + "." + name, said.at("final").value("validation_rmse", 0.0));
    const std::array<std::pair<const char*, const char*>, 2> kept{
        {{"delay_s", "transport_delay_s"}, {"offset_counts", "trim_counts"}}};
    for (const auto& [parameter, key] : kept) {
      folder.note(std::string(key) + "." + axis + "." + name, said.at("final").at("parameters").value(parameter, 0.0));
    }
  }
  return "";
}

std::string judge_margins(const Folder& folder, const std::string& result) {
  const json said = result_of(folder, result);
  for (const char* const axis : {"x", "y"}) {
    if (!said.at("margins").at(axis).value("stable", false)) {
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
                   "; the autopilot's last answer: " + said.value("last_reason", "none");
}

std::string judge_flight(const Folder& folder, const std::string& result) {
  const json said = result_of(folder, result);
  if (!said.value("obtained", false) || !said.value("released", false)) {
    return judge_handshake(folder, result);
  }
  for (const json& step : said.value("ladder", json::array())) {
    const std::string cause = step.value("cause", "");
    if (cause == "given_back") {
      break;  // the rungs after this one belong to the normal release
    }
    if (cause != "engaged") {
      return "the failsafe ladder left normal flight: " + step.value("from", "") + " to " + step.value("to", "") +
             ", " + step.value("seen", "");
    }
  }
  return "";
}

namespace {

double times_calmer(const Folder& folder) {
  const auto before = folder.numbers().find(kCalmer);
  return before == folder.numbers().end() ? 0.0 : before->second;
}

bool is_calmest(const Folder& folder) { return times_calmer(folder) >= kMostCalmer; }

/// Asks for calmer weights: the loop is too fast for the aircraft's real delay. @returns the sentence for the person.
std::string calmer(Folder& folder, const std::string& seen) {
  if (is_calmest(folder)) {
    return seen + ", also with the calmest weights. Check the delays in the log, and record a new flight by hand";
  }
  folder.note(kCalmer, times_calmer(folder) + 1.0);
  folder.again("gains");
  return seen + ": its delay is longer than in the vehicle file. The weights are made calmer; then hover again";
}

/// Notes the mean sticks of the settled part of a hover: the present trims of the aircraft.
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
  if (std::string why = judge_flight(folder, result); !why.empty()) {
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
  return calmer(folder, "the aircraft oscillates by " + rounded(most_deg) + " degrees root mean square");
}

std::string judge_course(Folder& folder, const std::string& name, const std::string& vehicle) {
  if (std::string why = judge_flight(folder, name + ".json"); !why.empty()) {
    return why;
  }
  const bool swung = result_of(folder, name + ".json").contains("swinging");
  if (swung && name == kBefore && !is_calmest(folder)) {
    return calmer(folder, "the aircraft began to oscillate on the course, and the calm law took over");
  }
  folder.note(kSwung + name, swung ? 1.0 : 0.0);
  return note_errors(folder, name, vehicle) ? "" : name + ".ulg: contains less than a second of flight under control";
}

std::string judge_excitation(Folder& folder, const std::string& result) {
  const json said = result_of(folder, result);
  if (said.contains("swinging") && !is_calmest(folder)) {
    return calmer(folder, "the aircraft began to oscillate in the excitation");  // the log shows the loop, not the axis
  }
  if (!said.contains("excitation") || said.at("excitation").value("over", false)) {
    return judge_flight(folder, result);
  }
  const std::string why = said.at("excitation").value("abort", json::object()).value("why", "control was lost");
  std::string seen = "the excitation was not flown to its end (" + why + ")";
  if (why == "not_at_rest") {
    return calmer(folder, seen);
  }
  if (why == "control was lost" || why == "ladder" || folder.numbers().contains(kBalanced)) {
    return seen;
  }
  folder.note(kBalanced, 1.0);
  folder.again("gains");
  return seen + ": the mean sticks of the hover become the trims; then hover again";
}

std::string judge_rates_excitation(Folder& folder, const std::string& result) {
  const json said = result_of(folder, result);
  const bool is_over = said.contains("excitation") && said.at("excitation").value("over", false);
  const std::string why =
      is_over
          ? judge_flight(folder, result)
          : said.value("excitation", json::object()).value("abort", json::object()).value("why", "control was lost");
  const bool was_flown_before = folder.numbers().contains(kRatesLeft) && folder.numbers().at(kRatesLeft) > 0.0;
  folder.note(kRatesLeft, why.empty() ? 0.0 : was_flown_before ? 2.0 : 1.0);
  if (why.empty() || was_flown_before) {
    return "";  // the models of roll and pitch do not need these movements
  }
  return "the movements of throttle and yaw were not flown to their end (" + why +
         "). Fly them once more; if they fail again, climb and yaw rate stay as in the first vehicle file";
}

}  // namespace m100::lab::evening
