// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/proposal/example_map.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <string_view>
#include <utility>

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/logs/stream.h"
#include "host_tests/lab/printable.h"

namespace m100::lab::logs {
namespace {

/// A column that may be the log's clock, and the scale that makes seconds of it.
struct ClockColumn {
  std::string name;
  const char* scale = "1";
};

/// The first column that increases at every row and is no row number, preferably one with the name of a time. The scale
/// follows from its mean step: flights are logged once a second to ten thousand times a second.
std::optional<ClockColumn> clock_of(const RawLog& log) {
  std::optional<ClockColumn> found;
  for (const std::string& name : first_names(log)) {
    const std::vector<double> t = numbers_of(log, name);
    const bool increases = t.size() > 2 && std::adjacent_find(t.begin(), t.end(), std::greater_equal<>()) == t.end();
    const double step = increases ? (t.back() - t.front()) / static_cast<double>(t.size() - 1) : 0.0;
    if (!(step > 0.0) || step == 1.0) {
      continue;
    }
    const char* const scale = step < 1.0 ? "1" : step < 1e3 ? "1e-3" : step < 1e6 ? "1e-6" : "1e-9";
    const bool is_named = name.find("ime") != std::string::npos || name.find("stamp") != std::string::npos ||
                          name == "t" || name.ends_with(".t") || name.ends_with("t_s");
    if (!found || is_named) {
      found = {.name = name, .scale = scale};
    }
    if (is_named) {
      break;
    }
  }
  return found;
}

/// The words of a name in small letters: divided at what is no letter and before a capital after a small letter.
std::vector<std::string> words_of(const std::string& name) {
  std::vector<std::string> out;
  char before = '_';
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalpha(byte) != 0) {
      const bool begins = std::isalpha(static_cast<unsigned char>(before)) == 0 ||
                          (std::isupper(byte) != 0 && std::islower(static_cast<unsigned char>(before)) != 0);
      out.resize(out.size() + (begins ? 1U : 0U));
      out.back() += static_cast<char>(std::tolower(byte));
    }
    before = c;
  }
  return out;
}

using Alias = std::pair<std::string_view, std::string_view>;
/// The words of the field and what they mean; an empty meaning is no signal of a map.
constexpr std::array<Alias, 31> kKinds{{{"error", ""},
                                        {"err", ""},
                                        {"command", "command"},
                                        {"commanded", "command"},
                                        {"cmd", "command"},
                                        {"desired", "command"},
                                        {"des", "command"},
                                        {"setpoint", "command"},
                                        {"sp", "command"},
                                        {"ref", "command"},
                                        {"reference", "command"},
                                        {"target", "command"},
                                        {"stick", "stick"},
                                        {"rc", "stick"},
                                        {"attitude", "attitude"},
                                        {"att", "attitude"},
                                        {"angle", "attitude"},
                                        {"velocity", "velocity"},
                                        {"vel", "velocity"},
                                        {"v", "velocity"},
                                        {"vx", "velocity"},
                                        {"vy", "velocity"},
                                        {"vz", "velocity"},
                                        {"position", "position"},
                                        {"pos", "position"},
                                        {"force", "force"},
                                        {"acceleration", "force"},
                                        {"acc", "force"},
                                        {"rate", "rate"},
                                        {"gyro", "rate"},
                                        {"omega", "rate"}}};
constexpr std::array<Alias, 13> kAxes{{{"roll", "roll"},
                                       {"pitch", "pitch"},
                                       {"yaw", "yaw"},
                                       {"heading", "yaw"},
                                       {"throttle", "throttle"},
                                       {"climb", "climb"},
                                       {"x", "x"},
                                       {"y", "y"},
                                       {"z", "z"},
                                       {"vx", "x"},
                                       {"vy", "y"},
                                       {"vz", "z"},
                                       {"thrust", "throttle"}}};
constexpr std::array<std::string_view, 4> kUnits{"rad", "deg", "m", "s"};

template <std::size_t N>
std::optional<std::string_view> meaning(const std::array<Alias, N>& table, std::string_view word) {
  const auto found = std::find_if(table.begin(), table.end(), [&](const Alias& one) { return one.first == word; });
  return found == table.end() ? std::nullopt : std::optional(found->second);
}

/// Takes a word's meaning into `known`; false if another meaning stands there.
bool agrees(std::string& known, std::string_view word) {
  const bool fits = known.empty() || known == word;
  known = word;
  return fits && !word.empty();
}

/// The signal of an axis that a kind of quantity has; "rate" of a command is the command of a rate.
std::optional<Signal> signal_of_kind(const std::string& kind, const std::string& axis, bool is_rate) {
  constexpr std::array<Alias, 3> kBodyAxes{{{"roll", "x"}, {"pitch", "y"}, {"yaw", "z"}}};
  if (is_rate && (kind.empty() || kind == "attitude")) {
    return signal_of("rate_" + std::string(meaning(kBodyAxes, axis).value_or(axis)));
  }
  const bool is_angle = meaning(kBodyAxes, axis).has_value();
  return signal_of((kind.empty() ? (is_angle ? "attitude" : "position") : kind) + "_" + axis +
                   (is_rate ? "_rate" : ""));
}

/// The line of a map for a column with this signal. Angles beyond a turn and faster rates are in degrees.
std::string line_of(Signal signal, const std::string& column, std::vector<double> values) {
  const std::string_view name = name_of(signal);
  std::string line = "  " + std::string(name) + " = ";
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  const bool is_stick = name.starts_with("stick_");
  const bool is_angle = signal != Signal::kCommandClimb &&
                        (name.starts_with("attitude_") || name.starts_with("command_") || name.starts_with("rate_"));
  const bool is_wide =
      std::any_of(values.begin(), values.end(), [](double v) { return std::abs(v) > 2.0 * std::numbers::pi; });
  const double neutral = is_stick && !values.empty() ? median(std::move(values)) : 0.0;
  const std::string start = line + "{ column = \"" + printable(column, 60) + "\", ";
  if (is_stick) {
    return start + "offset = " + std::to_string(-std::lround(neutral)) + " }  # counts from neutral\n";
  }
  return is_angle && is_wide ? start + "scale = 0.017453292519943 }  # degrees to radians\n"
                             : line + "\"" + printable(column, 60) + "\"\n";
}

}  // namespace

std::vector<double> numbers_of(const RawLog& log, const std::string& name) {
  try {
    return log.column(name, "time").values;
  } catch (const InputError&) {
    return {};
  }
}

std::vector<std::string> first_names(const RawLog& log) {
  constexpr std::size_t kMaxTried = 200;
  std::vector<std::string> names = log.names();
  names.resize(std::min(names.size(), kMaxTried));
  return names;
}

std::optional<Signal> signal_named(const std::string& column, std::size_t& unknown) {
  std::string kind;
  std::string axis;
  bool is_rate = false;
  bool is_one = true;
  unknown = 0;
  for (const std::string& word : words_of(column)) {
    const auto of_kind = meaning(kKinds, word);
    const auto of_axis = meaning(kAxes, word);
    is_rate = is_rate || of_kind == "rate";
    is_one =
        is_one && (!of_kind || of_kind == "rate" || agrees(kind, *of_kind)) && (!of_axis || agrees(axis, *of_axis));
    const bool is_unit = std::find(kUnits.begin(), kUnits.end(), word) != kUnits.end();
    unknown += of_kind || of_axis || is_unit ? 0U : 1U;
  }
  return is_one && !axis.empty() ? signal_of_kind(kind, axis, is_rate) : std::nullopt;
}

std::string example_map(const RawLog& log) {
  const std::optional<ClockColumn> clock = clock_of(log);
  std::array<std::pair<std::string, std::size_t>, kSignals> best;
  for (const std::string& name : first_names(log)) {
    std::size_t unknown = 0;
    const std::optional<Signal> signal = signal_named(name, unknown);
    auto& known = best[static_cast<std::size_t>(signal.value_or(Signal::kCount)) % kSignals];
    if (signal && (known.first.empty() || unknown < known.second) && !numbers_of(log, name).empty()) {
      known = {name, unknown};
    }
  }
  std::string commands;
  std::string responses;
  for (std::size_t i = 0; i < kSignals; ++i) {
    if (!best[i].first.empty()) {
      const auto signal = static_cast<Signal>(i);
      (signal < Signal::kAttitudeRoll ? commands : responses) +=
          line_of(signal, best[i].first, numbers_of(log, best[i].first));
    }
  }
  commands = commands.empty() ? line_of(Signal::kStickRoll, "...", {1500.0}) : commands;
  responses = responses.empty() ? line_of(Signal::kAttitudeRoll, "...", {90.0}) : responses;
  return "  time = { column = \"" + (clock ? printable(clock->name, 60) : "...") +
         "\", scale = " + (clock ? clock->scale : "1") + " }  # the scale converts to seconds\n  [signals]\n" +
         commands + responses;
}

}  // namespace m100::lab::logs
