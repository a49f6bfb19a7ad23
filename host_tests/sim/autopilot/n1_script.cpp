// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/autopilot/n1_script.h"

#include <algorithm>
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

N1Asked read_command(const std::string& text, long line) {
  for (const N1AskedWord& word : kN1AskedWords) {
    if (word.text == text) {
      return word.asked;
    }
  }
  throw N1ScriptError(line, "no command '" + text + "' is acknowledged");
}

struct StickWord {
  std::string_view name;
  N1StickMove::Shape shape;
};
constexpr std::array kStickWords{
    StickWord{"stick", N1StickMove::Shape::kStep}, StickWord{"doublet", N1StickMove::Shape::kDoublet},
    StickWord{"3211", N1StickMove::Shape::k3211}, StickWord{"chirp", N1StickMove::Shape::kChirp}};
constexpr std::array<std::string_view, 4> kStickNames{"roll", "pitch", "throttle", "yaw"};

/// The rest of a line whose word moves a stick.
N1StickMove read_move(N1StickMove::Shape shape, std::istringstream& words, long line) {
  N1StickMove move{.shape = shape};
  std::string stick, more;
  words >> stick >> move.counts;
  const auto* const found = std::find(kStickNames.begin(), kStickNames.end(), stick);
  if (shape == N1StickMove::Shape::kChirp) {
    words >> move.from_hz >> move.to_hz;
  }
  words >> move.seconds;
  const bool in_range = std::abs(move.counts) <= 660.0 && move.seconds > 0.0 && move.seconds <= 600.0 &&
                        move.from_hz >= 0.0 && move.from_hz <= 20.0 && move.to_hz >= 0.0 && move.to_hz <= 20.0;
  if (!words || words >> more || found == kStickNames.end() || !in_range) {
    throw N1ScriptError(line,
                        "expected: stick|doublet|3211 roll|pitch|throttle|yaw COUNTS SECONDS, or chirp STICK COUNTS "
                        "FROM_HZ TO_HZ SECONDS; at most 660 counts, 600 s, 20 Hz");
  }
  move.stick = static_cast<N1StickMove::Stick>(found - kStickNames.begin());
  return move;
}

N1ScriptLine read_line(const std::string& text, long number) {
  std::istringstream words(text);
  double at_s = 0.0;
  std::string name, value, command, more;
  if (!(words >> at_s) || !(at_s >= 0.0 && at_s <= 1e6) || !(words >> name)) {
    throw N1ScriptError(number, "expected: seconds, what happens, value");
  }
  const core::TimePoint at{core::Duration{std::llround(at_s * 1e6)}};
  for (const StickWord& known : kStickWords) {
    if (known.name == name) {
      return {.at = at, .what = N1Happening::kStick, .move = read_move(known.shape, words, number)};
    }
  }
  for (const Form& form : kForms) {
    if (form.name != name) {
      continue;
    }
    const bool takes_value = !form.words.empty() || form.low != form.high;
    if (takes_value != static_cast<bool>(words >> value) ||
        (form.what == N1Happening::kLoseAcks && words >> command && words >> more) || words >> more) {
      throw N1ScriptError(number, "'" + name + (takes_value ? "' takes one value" : "' takes no value"));
    }
    return {.at = at,
            .what = form.what,
            .value = takes_value ? read_value(form, value, number) : 0.0,
            .asked = command.empty() ? N1Asked::kAny : read_command(command, number)};
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
