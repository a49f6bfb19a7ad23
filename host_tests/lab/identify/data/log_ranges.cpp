// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/data/log_ranges.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <sstream>

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/logs/join.h"
#include "host_tests/lab/option_words.h"

namespace m100::lab::identify {
namespace {

/// Start and end of one of the joined logs, on its own clock.
Range own_times(const logs::FlightLog& log, std::size_t flight) {
  if (log.flights.empty()) {
    return {log.start_s, log.time_s(log.size - 1) + log.period_s};
  }
  const logs::Flight& one = log.flights[flight];
  return {one.start_s, one.start_s + static_cast<double>(one.end - one.begin) * log.period_s};
}

/// Whether the log is a single one with stretches whose times increase, so that a time has one place.
bool is_one_clock(const logs::FlightLog& log) {
  return !log.flights.empty() &&
         std::adjacent_find(log.flights.begin(), log.flights.end(), [](const logs::Flight& a, const logs::Flight& b) {
           return a.file != b.file || b.start_s <= a.start_s;
         }) == log.flights.end();
}

/// Converts "12:38", or "2@12:38" of the second log, to the common clock. A range of a single log may reach over
/// several of its stretches: then it becomes as many.
std::vector<Range> ranges_of(const std::string& option, const std::string& part, const logs::FlightLog& log) {
  const std::size_t at = part.find('@');
  std::size_t flight = 0;
  std::size_t last = 0;
  if (at != std::string::npos) {
    const double wanted = number(option, part.substr(0, at));
    if (!(wanted >= 1.0 && wanted <= static_cast<double>(std::max<std::size_t>(1, log.flights.size())) &&
          wanted == std::floor(wanted))) {
      throw InputError(option, 0, part, "names a log that was not given: logs are numbered from 1");
    }
    flight = last = static_cast<std::size_t>(wanted) - 1;
  } else if (is_one_clock(log)) {
    last = log.flights.size() - 1;
  } else if (!log.flights.empty()) {
    throw InputError(option, 0, part,
                     "with several logs each range names its log: 1@FROM:TO, 2@FROM:TO (and each stretch of a log "
                     "whose clock is set back)");
  }
  const std::vector<std::string> ends = parts(at == std::string::npos ? part : part.substr(at + 1), ':');
  if (ends.size() != 2) {
    throw InputError(option, 0, part, "a range is FROM:TO in seconds");
  }
  Range range{number(option, ends[0]), number(option, ends[1])};
  const double epoch_s = log.flights.empty() ? log.epoch_s : log.flights[flight].epoch_s;
  if (epoch_s > 0.0 && range.first >= epoch_s) {  // given on the clock before count_from_begin()
    range = {range.first - epoch_s, range.second - epoch_s};
  }
  const Range there{own_times(log, flight).first, own_times(log, last).second};
  if (!(range.first < range.second)) {
    throw InputError(option, 0, part, "ends before it begins");
  }
  if (range.first < there.first - 1e-9 || range.second > there.second + 0.5) {
    std::ostringstream message;
    message << "outside of the log, which covers " << there.first << " to " << there.second << " s";
    throw InputError(log.flights.empty() ? log.file : log.flights[flight].file, 0, option + " " + part, message.str());
  }
  std::vector<Range> out;
  for (; flight <= last; ++flight) {
    const Range own = own_times(log, flight);
    if (range.first < own.second && range.second > own.first) {
      out.emplace_back(logs::joined_time(log, flight, out.empty() ? std::max(range.first, own.first) : own.first),
                       logs::joined_time(log, flight, std::min(range.second, own.second)));
    }
  }
  if (out.empty()) {
    throw InputError(option, 0, part, "lies in a pause of the log");
  }
  return out;
}

/// A range of one of the given logs, on that log's own clock.
struct Piece {
  const logs::FlightLog* log;
  std::size_t flight;  ///< of a joined log
  std::size_t begin;   ///< first sample of the flight
  std::size_t size;
  double start_s;
  Range own;
  bool training;
};

void add_pieces(const logs::FlightLog& log, const std::vector<Range>& ranges, bool training, std::vector<Piece>& out) {
  for (const Range& range : ranges) {
    Piece piece{&log, 0, 0, log.size, log.start_s, range, training};
    for (std::size_t k = 0; k < log.flights.size(); ++k) {
      const logs::Flight& flight = log.flights[k];
      const double begins_s = log.time_s(flight.begin);
      if (range.first > begins_s - 0.5 * log.period_s) {
        const double shift_s = flight.start_s - begins_s;
        piece = {&log,           k,
                 flight.begin,   flight.end - flight.begin,
                 flight.start_s, {range.first + shift_s, range.second + shift_s},
                 training};
      }
    }
    out.push_back(piece);
  }
}

/// Whether a signal is a measurement, whose noise identifies a flight. Sticks and commands are the same in every flight
/// of one script, and row numbers are the same in every log.
bool is_measured(std::size_t signal) {
  const std::string_view name = logs::kSignalNames[signal];
  return !name.starts_with("stick_") && !name.starts_with("command_") && name != "sequence";
}

/// Whether two pieces are of one flight, whatever their files are: times and a moving, measured signal are equal.
bool same_flight(const Piece& a, const Piece& b) {
  if (a.log == b.log && a.flight == b.flight) {
    return true;
  }
  if (a.size != b.size || a.start_s != b.start_s || a.log->period_s != b.log->period_s) {
    return false;
  }
  for (std::size_t i = 0; i < logs::kSignals; ++i) {
    const std::vector<double>& x = a.log->signals[i];
    const std::vector<double>& y = b.log->signals[i];
    if (!is_measured(i) || x.empty() || y.empty()) {
      continue;
    }
    const auto from = x.begin() + static_cast<std::ptrdiff_t>(a.begin);
    const auto to = from + static_cast<std::ptrdiff_t>(a.size);
    const bool moves = std::any_of(from, to, [&](double value) { return value != *from; });
    if (moves && std::equal(from, to, y.begin() + static_cast<std::ptrdiff_t>(b.begin))) {
      return true;
    }
  }
  return false;
}

/// Whether two pieces have samples of one flight in common.
bool share_samples(const Piece& a, const Piece& b) {
  constexpr double kTouching_s = 1e-6;  // absolute time stamps have no more digits
  return a.own.first < b.own.second - kTouching_s && b.own.first < a.own.second - kTouching_s && same_flight(a, b);
}

/// The samples of some ranges in which a signal is missing or spoilt.
struct Gap {
  std::size_t samples = 0;
  std::size_t holes = 0;  ///< stretches of these samples, counted in each range
  double from_s = std::numeric_limits<double>::infinity();
  double to_s = -std::numeric_limits<double>::infinity();
  void add(const logs::FlightLog& log, std::size_t sample) {
    from_s = std::min(from_s, log.time_s(sample));
    to_s = std::max(to_s, log.time_s(sample + 1));
    ++samples;
  }
};

Gap gap_in(const logs::FlightLog& log, const std::vector<Range>& ranges, const std::vector<std::uint8_t>& missing) {
  Gap gap;
  for (const Range& range : ranges) {
    bool before = false;
    for (std::size_t k = log.index_of(range.first); k < log.index_of(range.second); ++k) {
      const bool now = missing[k] != 0;
      if (now) {
        gap.holes += before ? 0U : 1U;
        gap.add(log, k);
      }
      before = now;
    }
  }
  return gap;
}

}  // namespace

void reject_reused_data(const Request& request) {
  std::vector<Piece> pieces;
  add_pieces(*request.log, request.train, true, pieces);
  add_pieces(request.validation_log != nullptr ? *request.validation_log : *request.log, request.validate, false,
             pieces);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const Piece& a = pieces[i];
      const Piece& b = pieces[k];
      if (!share_samples(a, b)) {
        continue;
      }
      if (a.training == b.training) {
        throw InputError(a.training ? "--train" : "--validate", 0, "",
                         "has overlapping ranges of one flight: their samples would count twice");
      }
      throw InputError("--validate", 0, "",
                       "overlaps --train in the same flight: the error would be quoted on data the fit has seen");
    }
  }
}

std::vector<Range> ranges(const std::string& option, const std::string& text, const logs::FlightLog& log) {
  if (text.empty()) {
    throw InputError(option, 0, "", "is required (or --split)");
  }
  std::vector<Range> out;
  for (const std::string& part : list_of(option, text)) {
    const std::vector<Range> more = ranges_of(option, part, log);
    out.insert(out.end(), more.begin(), more.end());
  }
  return out;
}

void split(const std::string& text, const std::string& within, const logs::FlightLog& log, Request& request) {
  const std::vector<std::string> halves = parts(text, ':');
  if (halves.size() != 2 || halves[0] != "alternate") {
    throw InputError("--split", 0, text, "the only split is alternate:SECONDS");
  }
  const double length_s = number("--split", halves[1]);
  if (!(length_s >= 2.5)) {
    throw InputError("--split", 0, text, "pieces must be at least 2.5 s long");
  }
  std::vector<Range> all = within.empty() ? std::vector<Range>{} : ranges("--within", within, log);
  for (std::size_t flight = 0; within.empty() && flight < std::max<std::size_t>(1, log.flights.size()); ++flight) {
    const Range own = own_times(log, flight);
    all.emplace_back(logs::joined_time(log, flight, own.first),
                     logs::joined_time(log, flight, own.second - log.period_s));
  }
  for (const Range& range : all) {
    for (int piece = 0; range.first + (piece + 1) * length_s <= range.second + 1e-9; ++piece) {
      const Range one{range.first + piece * length_s, range.first + (piece + 1) * length_s};
      (piece % 2 == 0 || !in_one_log(request) ? request.train : request.validate).push_back(one);
    }
  }
}

void date_findings(const Request& request, std::vector<Finding>& findings) {
  if (request.train.empty()) {
    return;
  }
  Range used = request.train.front();
  for (const std::vector<Range>& part : {request.train, request.validate}) {
    for (const Range& range : part) {
      used = {std::min(used.first, range.first), std::max(used.second, range.second)};
    }
  }
  for (Finding& finding : findings) {
    if (!(finding.to_s > finding.from_s)) {
      finding.from_s = used.first;
      finding.to_s = used.second;
    }
  }
}

void find_gaps(const logs::FlightLog& log, const std::vector<Range>& ranges, std::vector<Finding>& findings) {
  struct Hole {
    Gap gap;
    std::vector<std::string> signals;
  };
  std::vector<Hole> all;  // signals that are missing in the same samples share a line
  for (const auto& [signal, missing] : log.signal_gap) {
    const Gap gap = gap_in(log, ranges, missing);
    if (gap.samples == 0 || !log.has(signal)) {
      continue;
    }
    const auto same = std::find_if(all.begin(), all.end(), [&](const Hole& one) {
      return one.gap.samples == gap.samples && one.gap.holes == gap.holes && one.gap.from_s == gap.from_s &&
             one.gap.to_s == gap.to_s;
    });
    const auto at = same == all.end() ? all.insert(all.end(), {gap, {}}) : same;
    at->signals.emplace_back(logs::name_of(signal));
  }
  for (const Hole& one : all) {
    constexpr std::size_t kShown = 2;
    std::string names = one.signals.front();
    for (std::size_t i = 1; i < std::min(kShown, one.signals.size()); ++i) {
      names += ", " + one.signals[i];
    }
    const std::size_t more = one.signals.size() - std::min(kShown, one.signals.size());
    names += more > 0 ? " and " + std::to_string(more) + " more signals" : "";
    Finding found{.what = "gap", .signal = one.signals.front()};
    found.from_s = one.gap.from_s;
    found.to_s = one.gap.to_s;
    found.text = names + (one.signals.size() > 1 ? " are" : " is") + " missing or spoilt in " +
                 std::to_string(one.gap.holes) + (one.gap.holes == 1 ? " place" : " places") + " of the ranges used, " +
                 std::to_string(one.gap.samples) + " samples in all, first at " + logs::place_of(log, one.gap.from_s) +
                 "; excluded";
    findings.push_back(std::move(found));
  }
}

}  // namespace m100::lab::identify
