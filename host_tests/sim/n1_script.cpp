// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/n1_script.h"

#include <array>
#include <cmath>
#include <span>
#include <sstream>
#include <string_view>

namespace m100::sim {
namespace {

struct Word {
  std::string_view text;
  double value;
};
constexpr std::array kModes{Word{"F", 'F'}, Word{"A", 'A'}, Word{"P", 'P'}};
constexpr std::array kSwitches{Word{"on", 1.0}, Word{"off", 0.0}};
constexpr std::array kTakers{Word{"mobile", 'm'}, Word{"rc", 'r'}};

struct Form {
  std::string_view name;
  N1Happening what;
  std::span<const Word> words;  ///< empty: a number
  double low = 0.0;
  double high = 0.0;  ///< low == high and no words: takes no value
};
constexpr std::array kForms{
    Form{"mode", N1Happening::kMode, kModes},
    Form{"rc", N1Happening::kRc, kSwitches},
    Form{"take", N1Happening::kTake, kTakers},
    Form{"ioc", N1Happening::kIoc, kSwitches},
    Form{"restart", N1Happening::kRestart, {}},
    Form{"end_virtual_rc", N1Happening::kEndVirtualRc, {}},
    Form{"silence", N1Happening::kSilence, {}, 0.0, 3600.0},
    Form{"lose_acks", N1Happening::kLoseAcks, {}, 0.0, 1e6},
    Form{"delay_acks", N1Happening::kDelayAcks, {}, 0.0, 60.0},
    Form{"double_acks", N1Happening::kDoubleAcks, {}, 0.0, 1e6},
    Form{"noise", N1Happening::kNoise, {}, 1.0, 2048.0},
    Form{"loss", N1Happening::kLoss, {}, 0.0, 1.0},
    Form{"activation", N1Happening::kActivation, {}, 0.0, 65535.0},
};

double read_value(const Form& form, const std::string& word, long line) {
  for (const Word& known : form.words) {
    if (known.text == word) {
      return known.value;
    }
  }
  if (!form.words.empty()) {
    throw N1ScriptError(line, "'" + std::string(form.name) + "' cannot be '" + word + "'");
  }
  std::size_t used = 0;
  double value = NAN;
  try {
    value = std::stod(word, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used != word.size() || used == 0 || !(value >= form.low && value <= form.high)) {
    throw N1ScriptError(line, "'" + std::string(form.name) + "' needs a number from " + std::to_string(form.low) +
                                  " to " + std::to_string(form.high));
  }
  return value;
}

N1ScriptLine read_line(const std::string& text, long number) {
  std::istringstream words(text);
  double at_s = 0.0;
  std::string name, value, more;
  if (!(words >> at_s) || !(at_s >= 0.0 && at_s <= 1e6) || !(words >> name)) {
    throw N1ScriptError(number, "expected: seconds, what happens, value");
  }
  for (const Form& form : kForms) {
    if (form.name != name) {
      continue;
    }
    const bool takes_value = !form.words.empty() || form.low != form.high;
    if (takes_value != static_cast<bool>(words >> value) || words >> more) {
      throw N1ScriptError(number, "'" + name + (takes_value ? "' takes one value" : "' takes no value"));
    }
    return {.at = core::TimePoint{core::Duration{std::llround(at_s * 1e6)}},
            .what = form.what,
            .value = takes_value ? read_value(form, value, number) : 0.0};
  }
  throw N1ScriptError(number, "unknown: '" + name + "'");
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
      throw N1ScriptError(number, "times must not fall");
    }
  }
  return script;
}

}  // namespace m100::sim
