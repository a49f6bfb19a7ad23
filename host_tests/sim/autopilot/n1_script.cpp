// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/autopilot/n1_script.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string_view>

#include "firmware/companion/files/text/suggestion.h"
#include "host_tests/sim/autopilot/n1_script_syntax.h"

namespace m100::sim {
namespace {

using companion::did_you_mean;

double read_value(const N1EventSyntax& form, const std::string& word, long line) {
  for (const N1NamedValue& known : form.words) {
    if (known.text == word) {
      return known.value;
    }
  }
  if (!form.words.empty()) {
    throw N1ScriptError(line, "'" + std::string(form.name) + "' cannot be '" + word + "'" +
                                  did_you_mean(word, form.words, &N1NamedValue::text));
  }
  std::size_t used = 0;
  double value = NAN;
  try {
    value = std::stod(word, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used != word.size() || used == 0 || !(value >= form.low && value <= form.high) ||
      (form.whole && value != std::floor(value))) {
    throw N1ScriptError(line, "'" + std::string(form.name) + "' needs a " + (form.whole ? "whole " : "") +
                                  "number from " + std::to_string(form.low) + " to " + std::to_string(form.high));
  }
  return value;
}

N1Request read_command(const std::string& text, long line) {
  for (const N1RequestName& word : kN1RequestNames) {
    if (word.text == text) {
      return word.request;
    }
  }
  throw N1ScriptError(line, "'" + text + "' is not an acknowledged command" +
                                did_you_mean(text, kN1RequestNames, &N1RequestName::text));
}

/// Reads the rest of a line that moves a stick.
N1StickMove read_move(N1StickMove::Shape shape, std::istringstream& words, long line) {
  N1StickMove move{.shape = shape};
  std::string stick, more;
  words >> stick >> move.counts;
  const auto* const found = std::find(kN1StickNames.begin(), kN1StickNames.end(), stick);
  if (shape == N1StickMove::Shape::kChirp) {
    words >> move.from_hz >> move.to_hz;
  }
  words >> move.seconds;
  const bool in_range = std::abs(move.counts) <= 660.0 && move.seconds > 0.0 && move.seconds <= 600.0 &&
                        move.from_hz >= 0.0 && move.from_hz <= 20.0 && move.to_hz >= 0.0 && move.to_hz <= 20.0;
  if (!words || words >> more || found == kN1StickNames.end() || !in_range) {
    throw N1ScriptError(line,
                        "expected: stick|doublet|3211 roll|pitch|throttle|yaw COUNTS SECONDS, or chirp STICK COUNTS "
                        "FROM_HZ TO_HZ SECONDS; at most 660 counts, 600 s, 20 Hz");
  }
  move.stick = static_cast<N1StickMove::Stick>(found - kN1StickNames.begin());
  return move;
}

/// Reads the rest of a line that starts a sensor fault.
N1ScriptLine read_fault(core::TimePoint at, std::istringstream& words, long line) {
  std::string name, more;
  words >> name;
  const SensorFault* const fault = find_sensor_fault(name);
  if (fault == nullptr) {
    throw N1ScriptError(
        line, "unknown sensor fault '" + name + "'" + did_you_mean(name, sensor_faults(), &SensorFault::name));
  }
  double size = fault->size;
  const bool has_size = static_cast<bool>(words >> size);
  if ((has_size && fault->unit.empty()) || (!has_size && !words.eof()) || words >> more || !(std::abs(size) <= 1e4)) {
    throw N1ScriptError(line, "expected: fault NAME, and a number if the fault has a size");
  }
  return {.at = at, .what = N1EventKind::kSensorFault, .value = has_size ? size : fault->size, .fault = fault};
}

N1ScriptLine read_form(const N1EventSyntax& form, core::TimePoint at, std::istringstream& words, long number) {
  std::string value, command, more;
  const bool takes_value = !form.words.empty() || form.low != form.high;
  if (takes_value != static_cast<bool>(words >> value) ||
      (form.what == N1EventKind::kLoseAcks && words >> command && words >> more) || words >> more) {
    throw N1ScriptError(number,
                        "'" + std::string(form.name) + (takes_value ? "' takes one value" : "' takes no value"));
  }
  return {.at = at,
          .what = form.what,
          .value = takes_value ? read_value(form, value, number) : 0.0,
          .request = command.empty() ? N1Request::kAny : read_command(command, number)};
}

std::string word_meant(const std::string& word) {
  std::vector<std::string_view> known{kN1FaultWord};
  for (const N1EventSyntax& form : kN1Events) {
    known.push_back(form.name);
  }
  for (const N1StickShapeName& shape : kN1StickShapes) {
    known.push_back(shape.name);
  }
  return did_you_mean(word, known);
}

N1ScriptLine read_line(const std::string& text, long number) {
  std::istringstream words(text);
  double at_s = 0.0;
  std::string name;
  if (!(words >> at_s) || !(at_s >= 0.0 && at_s <= 1e6) || !(words >> name)) {
    throw N1ScriptError(number, "expected: SECONDS WORD, and the values that the word takes");
  }
  const core::TimePoint at{core::Duration{std::llround(at_s * 1e6)}};
  for (const N1StickShapeName& known : kN1StickShapes) {
    if (known.name == name) {
      return {.at = at, .what = N1EventKind::kStick, .move = read_move(known.shape, words, number)};
    }
  }
  if (name == kN1FaultWord || name == kN1FaultWordBefore) {
    return read_fault(at, words, number);
  }
  const auto form =
      std::find_if(kN1Events.begin(), kN1Events.end(), [&](const N1EventSyntax& one) { return one.name == name; });
  if (form == kN1Events.end()) {
    throw N1ScriptError(number, "unknown word '" + name + "'" + word_meant(name));
  }
  return read_form(*form, at, words, number);
}

}  // namespace

std::vector<N1ScriptLine> read_n1_script(const std::string& text) {
  std::vector<N1ScriptLine> script;
  std::istringstream lines(text);
  std::string line;
  for (long number = 1; std::getline(lines, line); ++number) {
    line = line.substr(0, line.find('#'));
    if (line.find_first_not_of(" \t\r") == std::string::npos) {
      continue;
    }
    script.push_back(read_line(line, number));
    if (script.size() > 1 && script.back().at < script[script.size() - 2].at) {
      throw N1ScriptError(number, "times must not decrease");
    }
  }
  return script;
}

}  // namespace m100::sim
