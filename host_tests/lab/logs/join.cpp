// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/join.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace m100::lab::logs {
namespace {

constexpr double kPause_s = 5.0;  // longer than any model's memory of its input (3 s) and than any filter

void append(std::vector<double>& to, const std::vector<double>& more, std::size_t pause) {
  to.insert(to.end(), to.empty() ? 0 : pause, more.front());
  to.insert(to.end(), more.begin(), more.end());
}

void append_gap(std::vector<std::uint8_t>& to, const std::vector<std::uint8_t>& more, std::size_t size,
                std::size_t pause) {
  to.insert(to.end(), to.empty() ? 0 : pause, std::uint8_t{1});
  more.empty() ? static_cast<void>(to.insert(to.end(), size, std::uint8_t{0}))
               : static_cast<void>(to.insert(to.end(), more.begin(), more.end()));
}

void join_signals(const std::vector<FlightLog>& logs, std::size_t pause, FlightLog& out) {
  for (std::size_t i = 0; i < kSignals; ++i) {
    const auto signal = static_cast<Signal>(i);
    const auto have = std::count_if(logs.begin(), logs.end(), [&](const FlightLog& log) { return log.has(signal); });
    if (have < std::ssize(logs)) {
      if (have > 0) {
        out.notes.push_back(std::string(name_of(signal)) + " is not in every log and is left out");
      }
      continue;
    }
    for (const FlightLog& log : logs) {
      append(out.of(signal), log.of(signal), pause);
      append_gap(out.signal_gap[signal], log.gap_of({signal}), log.size, pause);
      out.row_s[signal] = std::max(out.row_s[signal], log.logged_row_of(signal));
    }
  }
  for (const auto& [name, unused] : logs.front().extra) {
    const bool everywhere = std::all_of(logs.begin(), logs.end(),
                                        [&, key = name](const FlightLog& log) { return log.extra.count(key) > 0; });
    for (const FlightLog& log : logs) {
      if (everywhere) {
        append(out.extra[name], log.extra.at(name), pause);
      }
    }
  }
}

}  // namespace

void count_from_begin(FlightLog& log) {
  constexpr double kOtherEpoch_s = 1e7;
  if (log.start_s < kOtherEpoch_s) {
    return;
  }
  log.epoch_s = std::floor(log.start_s);
  log.start_s -= log.epoch_s;
  std::array<char, 120> text{};
  std::snprintf(text.data(), text.size(),
                "times are counted from %.0f s of the log's clock; ranges may count either way", log.epoch_s);
  log.notes.emplace_back(text.data());
}

FlightLog joined(std::vector<FlightLog> logs) {
  if (logs.size() == 1) {
    return std::move(logs.front());
  }
  FlightLog out;
  out.start_s = logs.front().start_s;
  out.period_s = logs.front().period_s;
  out.velocity_mean_s = logs.front().velocity_mean_s;
  out.alignment = logs.front().alignment;
  const auto pause = static_cast<std::size_t>(std::lround(kPause_s / out.period_s));
  for (std::size_t i = 0; i < logs.size(); ++i) {
    const FlightLog& log = logs[i];
    const std::string number = std::to_string(i + 1);
    const std::size_t begin = out.size + (i == 0 ? 0 : pause);
    out.file += (i == 0 ? "" : " + ") + log.file;
    out.columns += (i == 0 ? "" : " + ") + log.columns;
    out.flights.push_back({log.file, begin, begin + log.size, log.start_s, log.epoch_s});
    out.size = begin + log.size;
    append_gap(out.gap, log.gap, log.size, pause);
    for (const std::string& note : log.notes) {
      out.notes.push_back("log " + number + ": " + note);
    }
    for (const std::string& note : log.gap_notes) {
      out.gap_notes.push_back("log " + number + ": " + note);
    }
    if (i > 0) {
      std::array<char, 120> text{};
      std::snprintf(text.data(), text.size(), ": its time %.2f s is %.2f s on the common clock, which the result uses",
                    log.start_s, out.time_s(begin));
      out.notes.push_back("log " + number + text.data());
    }
  }
  join_signals(logs, pause, out);
  return out;
}

double joined_time(const FlightLog& log, std::size_t flight, double own_s) {
  return log.flights.empty() ? own_s : log.time_s(log.flights[flight].begin) + own_s - log.flights[flight].start_s;
}

std::string place_of(const FlightLog& log, double time_s) {
  std::string prefix;
  double own_s = time_s;
  for (std::size_t i = 0; i < log.flights.size(); ++i) {
    const double begins_s = log.time_s(log.flights[i].begin);
    if (time_s >= begins_s - 0.5 * log.period_s) {
      prefix = std::to_string(i + 1) + "@";
      own_s = time_s - begins_s + log.flights[i].start_s;
    }
  }
  char text[40];
  std::snprintf(text, sizeof text, "%.2f s", own_s);
  return prefix + text;
}

std::vector<std::uint8_t> FlightLog::gap_of(std::initializer_list<Signal> wanted) const {
  if (signal_gap.empty()) {
    return gap;
  }
  std::vector<std::uint8_t> out(size, 0);
  for (const Signal signal : wanted) {
    if (const auto found = signal_gap.find(signal); found != signal_gap.end()) {
      std::transform(out.begin(), out.end(), found->second.begin(), out.begin(),
                     [](std::uint8_t a, std::uint8_t b) { return a | b; });
    }
  }
  return out;
}

}  // namespace m100::lab::logs
