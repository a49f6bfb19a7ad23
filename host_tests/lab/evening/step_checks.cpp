// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/evening/step_checks.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "firmware/companion/files/text/json.h"
#include "host_tests/lab/aliases.h"
#include "host_tests/lab/campaign/oscillation.h"
#include "host_tests/lab/evening/flight_result.h"
#include "host_tests/lab/evening/steps.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::evening {
namespace {

constexpr double kFull_counts = 660.0;       ///< of a stick pushed to its end
constexpr double kMinMoved_counts = 60.0;    ///< to both sides, for roll and pitch: a fit cannot tell less from noise
constexpr double kWorstFit_percent = 50.0;   ///< on the validation part; below it the log does not show the axis
constexpr double kTrimmed_s = 5.0;           ///< the first seconds of a hover, not used for its mean sticks
constexpr double kMaxWeightIncreases = 2.0;  ///< how often the input weight grows at most

std::string rounded(double value) { return printed("%.3g", value); }

/// "60 counts (9 % of the stick)".
std::string as_pilots_say(double counts) {
  return rounded(counts) + " counts (" + rounded(std::round(100.0 * counts / kFull_counts)) + " % of the stick)";
}

/// Whether hand.ulg is a log of m100 fly; false if it cannot be read.
bool is_flight_by_law(const Folder& folder) {
  try {
    const std::vector<std::string> columns = logs::open_log(folder.file("hand.ulg"))->names();
    return std::find(columns.begin(), columns.end(), "tick.timestamp") != columns.end();
  } catch (const InputError&) {
    return false;
  }
}

bool is_weight_at_limit(const Folder& folder) { return folder.number(kWeightIncreases) >= kMaxWeightIncreases; }

/// Requests a larger input weight, if it may still grow, because the loop is too fast. @returns what the person reads
std::string increase_input_weight(Folder& folder, const std::string& seen) {
  if (is_weight_at_limit(folder)) {
    return seen + ", also with the calmest weights. Check the delays in the log, and record a new flight by hand";
  }
  folder.set_number(kWeightIncreases, folder.number(kWeightIncreases) + 1.0);
  folder.again("gains");
  return seen + ": its delay is longer than in the vehicle file. The weights are made calmer; then hover again";
}

/// Records the mean sticks of the settled part of a hover: the present trims of the aircraft.
void record_trim(Folder& folder, const logs::FlightLog& flight, std::pair<double, double> flown) {
  const std::size_t first = flight.index_of(flown.first + kTrimmed_s);
  const std::size_t last = flight.index_of(flown.second);
  for (const auto& [signal, name] :
       {std::pair{logs::Signal::kStickRoll, kTrimRoll}, std::pair{logs::Signal::kStickPitch, kTrimPitch}}) {
    double sum = 0.0;
    for (std::size_t k = first; k < last; ++k) {
      sum += flight.of(signal)[k];
    }
    if (last > first) {
      folder.set_number(name, sum / static_cast<double>(last - first));
    }
  }
}

}  // namespace

std::string check_probe(const Folder& folder, const std::string& result) {
  const Json result_json = result_of(folder, result);
  const std::string verdict = result_json.value("verdict", "");
  return verdict == "autopilot"
             ? ""
             : "the board heard '" + verdict + "' instead of an autopilot: " + result_json.value("remedy", "");
}

std::string check_recording(const Folder& folder, const std::string& result) {
  if (is_flight_by_law(folder)) {
    return "hand.ulg is the log of a flight of m100 fly, in which the law moved the sticks: record a flight by hand";
  }
  const Json result_json = result_of(folder, result);
  if (!result_json.value("recorded", false)) {
    return "nothing useful was recorded: " + result_json.value("trouble", "no reason given");
  }
  for (const char* const stick : {"roll", "pitch"}) {
    const Json& moved = result_json.at("sticks").at(stick);
    if (moved.value("most_counts", 0.0) < kMinMoved_counts || moved.value("least_counts", 0.0) > -kMinMoved_counts) {
      return std::string("the ") + stick + " stick moved from " + rounded(moved.value("least_counts", 0.0)) + " to " +
             rounded(moved.value("most_counts", 0.0)) + " counts: move it by at least " +
             as_pilots_say(kMinMoved_counts) + " to both sides";
    }
  }
  return "";
}

std::string check_identification(Folder& folder, const std::vector<std::string>& answers, const std::string& name) {
  for (const std::string& answer : answers) {
    const Json result_json = result_of(folder, answer);
    const double fit = result_json.at("final").value("fit_percent", 0.0);
    const std::string axis = result_json.value("axis", answer);
    if (fit < kWorstFit_percent) {
      return axis + ": the model explains only " + rounded(fit) + " % of the validation part of the log; at least " +
             rounded(kWorstFit_percent) + " % is needed. Excite the axis more, or see " + answer;
    }
    folder.set_number("rmse_rad." + axis + "." + name, result_json.at("final").value("validation_rmse", 0.0));
    const std::array<std::pair<const char*, const char*>, 2> kept{
        {{"delay_s", "transport_delay_s"}, {"offset_counts", "trim_counts"}}};
    for (const auto& [parameter, key] : kept) {
      folder.set_number(std::string(key) + "." + axis + "." + name,
                        result_json.at("final").at("parameters").value(parameter, 0.0));
    }
  }
  return "";
}

std::string check_margins(const Folder& folder, const std::string& result) {
  const Json result_json = result_of(folder, result);
  for (const char* const axis : {"x", "y"}) {
    for (const Json& margins : result_json.at("flown").at("its own structure").at(axis)) {
      if (!margins.value("stable", false)) {
        return std::string("the loop of axis ") + axis + " is not stable with these weights; see " + result;
      }
    }
  }
  return "";
}

std::string check_handshake(const Folder& folder, const std::string& result) {
  const Json result_json = result_of(folder, result);
  return result_json.value("obtained", false) && result_json.value("released", false)
             ? ""
             : "control was " + std::string(result_json.value("obtained", false) ? "not given back" : "not obtained") +
                   "; the autopilot's last answer: " + result_json.value("last_reason", "none");
}

std::string check_flight(const Folder& folder, const std::string& result) {
  const Json result_json = result_of(folder, result);
  if (!result_json.value("obtained", false) || !result_json.value("released", false)) {
    return check_handshake(folder, result);
  }
  for (const Json& step : result_json.value("failsafe", Json::array())) {
    const std::string cause = step.value("cause", "");
    if (cause == "given_back") {
      break;  // the states after this one belong to the normal release
    }
    if (cause != "engaged") {
      return "the failsafe state machine left normal flight: " + step.value("from", "") + " to " +
             step.value("to", "") + ", " + step.value("seen", "");
    }
  }
  return "";
}

std::string check_hover(Folder& folder, const std::string& name) {
  const std::string result = name + ".json";
  if (std::string why = check_flight(folder, result); !why.empty()) {
    return why;
  }
  const std::pair<double, double> flown = nominal(result_of(folder, result));
  const logs::FlightLog flight = tracked(folder, name + ".ulg");
  experiments::Trace trace;
  for (std::size_t k = flight.index_of(flown.first + kSettled_s); k < flight.index_of(flown.second); ++k) {
    trace.push_back({.roll_rad = flight.of(logs::Signal::kAttitudeRoll)[k],
                     .pitch_rad = flight.of(logs::Signal::kAttitudePitch)[k]});
  }
  const campaign::TiltOscillation swing = campaign::measure_oscillation(trace);
  const double most_deg = std::max(swing.roll_deviation_deg, swing.pitch_deviation_deg);
  folder.set_number("oscillation_deg." + name, most_deg);
  record_trim(folder, flight, flown);
  if (!swing.periodic && !result_of(folder, result).contains("swinging")) {
    return "";
  }
  return increase_input_weight(folder, "the aircraft oscillates by " + rounded(most_deg) + " degrees root mean square");
}

std::string check_course(Folder& folder, const std::string& name) {
  if (std::string why = check_flight(folder, name + ".json"); !why.empty()) {
    return why;
  }
  const bool swung = result_of(folder, name + ".json").contains("swinging");
  if (swung && name == kBefore && !is_weight_at_limit(folder)) {
    return increase_input_weight(folder,
                                 "the aircraft began to oscillate on the course, and the fallback law took over");
  }
  folder.set_number(kFallbackLaw + name, swung ? 1.0 : 0.0);
  return record_errors(folder, name) ? "" : name + ".ulg: contains less than a second of flight under control";
}

std::string check_excitation(Folder& folder, const std::string& result) {
  const Json result_json = result_of(folder, result);
  if (result_json.contains("swinging") && !is_weight_at_limit(folder)) {
    return increase_input_weight(
        folder, "the aircraft began to oscillate in the excitation");  // the log shows the loop, not the axis
  }
  if (!result_json.contains("excitation") || result_json.at("excitation").value("over", false)) {
    return check_flight(folder, result);
  }
  const std::string why = result_json.at("excitation").value("abort", Json::object()).value("why", "control was lost");
  std::string seen = "the excitation was not flown to its end (" + why + ")";
  if (why == "not_at_rest") {
    return increase_input_weight(folder, seen);
  }
  if (why == "control was lost" || alias_of(why) == "failsafe" || folder.numbers().contains(kTrimmed)) {
    return seen;
  }
  folder.set_number(kTrimmed, 1.0);
  folder.again("gains");
  return seen + ": the mean sticks of the hover become the trims; then hover again";
}

std::string check_rates_excitation(Folder& folder, const std::string& result) {
  const Json result_json = result_of(folder, result);
  const bool is_over = result_json.contains("excitation") && result_json.at("excitation").value("over", false);
  const std::string why = is_over ? check_flight(folder, result)
                                  : result_json.value("excitation", Json::object())
                                        .value("abort", Json::object())
                                        .value("why", "control was lost");
  const bool was_flown_before = folder.number(kRatesNotFlown) > 0.0;
  folder.set_number(kRatesNotFlown, why.empty() ? 0.0 : was_flown_before ? 2.0 : 1.0);
  if (why.empty() || was_flown_before) {
    return "";  // the models of roll and pitch do not need these movements
  }
  return "the movements of throttle and yaw were not flown to their end (" + why +
         "). Fly them once more; if they fail again, climb and yaw rate stay as in the first vehicle file";
}

}  // namespace m100::lab::evening
