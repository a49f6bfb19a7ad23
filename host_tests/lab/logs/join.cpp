// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/join.h"

#include <algorithm>
#include <cmath>

#include "host_tests/lab/logs/stretches.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::logs {
namespace {

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

/// Notes for each log and stretch after the first where it lies on the clock of the result.
void note_common_clock(FlightLog& log) {
  for (std::size_t i = 1; i < log.flights.size(); ++i) {
    log.notes.push_back(printed("log %zu: its time %.2f s is %.2f s on the common clock, which the result uses", i + 1,
                                log.flights[i].start_s, log.time_s(log.flights[i].begin)));
  }
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

std::vector<Flight> flights_of(const std::vector<Stretch>& stretches, const std::string& file, const FlightLog& log) {
  std::vector<Flight> out;
  for (std::size_t i = 0; i < stretches.size() && stretches.size() > 1; ++i) {
    const Stretch& one = stretches[i];
    const auto begin = static_cast<std::size_t>(std::llround((one.from_s + one.shift_s - log.start_s) / log.period_s));
    const auto last = static_cast<std::size_t>(std::floor((one.to_s - one.from_s) / log.period_s + 1e-6));
    out.push_back({file, begin, std::min(begin + last + 1, log.size), one.from_s, 0.0});
  }
  return out;
}

void fill_pauses(FlightLog& log) {
  for (std::size_t i = 1; i < log.flights.size(); ++i) {
    const auto begin = static_cast<std::ptrdiff_t>(log.flights[i - 1].end);
    const auto end = static_cast<std::ptrdiff_t>(log.flights[i].begin);
    std::fill(log.gap.begin() + begin, log.gap.begin() + end, std::uint8_t{1});
    for (std::size_t k = 0; k < kSignals; ++k) {
      if (std::vector<double>& values = log.signals[k]; !values.empty()) {
        std::vector<std::uint8_t>& gap = log.signal_gap[static_cast<Signal>(k)];
        gap.resize(log.size, 0);
        std::fill(gap.begin() + begin, gap.begin() + end, std::uint8_t{1});
        std::fill(values.begin() + begin, values.begin() + end, *(values.begin() + end));
      }
    }
    for (auto& [name, values] : log.extra) {
      std::fill(values.begin() + begin, values.begin() + end, *(values.begin() + end));
    }
  }
}

void add_gaps(std::vector<std::uint8_t>& gap, const std::vector<std::uint8_t>& more) {
  std::transform(gap.begin(), gap.end(), more.begin(), gap.begin(), [](auto a, auto b) { return a | b; });
}

void note_gaps(FlightLog& log) {
  std::size_t holes = 0;
  std::size_t lost = 0;
  for (const Flight& part : log.parts()) {
    for (std::size_t k = part.begin; k < part.end; ++k) {
      lost += log.gap[k];
      holes += log.gap[k] != 0 && (k == part.begin || log.gap[k - 1] == 0) ? 1U : 0U;
    }
  }
  if (holes > 0) {
    log.gap_notes.push_back(std::to_string(holes) + (holes == 1 ? " gap, " : " gaps, ") + std::to_string(lost) +
                            " samples of " + std::to_string(log.size) + " are excluded");
  }
}

void count_from_begin(FlightLog& log) {
  constexpr double kOtherEpoch_s = 1e7;
  if (log.start_s < kOtherEpoch_s) {
    return;
  }
  log.epoch_s = std::floor(log.start_s);
  log.start_s -= log.epoch_s;
  for (Flight& stretch : log.flights) {  // of a clock that was set, some may count from the other epoch
    stretch.epoch_s = stretch.start_s < kOtherEpoch_s ? 0.0 : log.epoch_s;
    stretch.start_s -= stretch.epoch_s;
  }
  log.notes.push_back(
      printed("times are counted from %.0f s of the log's clock; ranges may count either way", log.epoch_s));
}

FlightLog joined(std::vector<FlightLog> logs) {
  if (logs.size() == 1) {
    note_common_clock(logs.front());
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
    const std::string number = std::to_string(out.flights.size() + 1);
    const std::size_t begin = out.size + (i == 0 ? 0 : pause);
    out.file += (i == 0 ? "" : " + ") + log.file;
    out.columns += (i == 0 ? "" : " + ") + log.columns;
    for (const Flight& part : log.parts()) {
      out.flights.push_back({log.file, begin + part.begin, begin + part.end, part.start_s, part.epoch_s});
    }
    out.size = begin + log.size;
    append_gap(out.gap, log.gap, log.size, pause);
    for (const std::string& note : log.notes) {
      out.notes.push_back("log " + number + ": " + note);
    }
    for (const std::string& note : log.gap_notes) {
      out.gap_notes.push_back("log " + number + ": " + note);
    }
  }
  note_common_clock(out);
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
  return prefix + printed("%.2f s", own_s);
}

std::vector<std::uint8_t> FlightLog::gap_of(std::initializer_list<Signal> wanted) const {
  if (signal_gap.empty()) {
    return gap;
  }
  std::vector<std::uint8_t> out(size, 0);
  for (const Signal signal : wanted) {
    if (const auto found = signal_gap.find(signal); found != signal_gap.end()) {
      add_gaps(out, found->second);
    }
  }
  return out;
}

}  // namespace m100::lab::logs
