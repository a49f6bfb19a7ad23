// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/write_csv.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <numeric>

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::logs {
namespace {

struct Column {
  std::string name;
  const std::vector<double>* values;
  std::vector<std::uint8_t> gap;  ///< 1: the value was not sampled; empty: there are no gaps
};

std::vector<Column> columns_of(const FlightLog& log) {
  std::vector<Column> out;
  for (std::size_t i = 0; i < kSignals; ++i) {
    if (!log.signals[i].empty()) {
      out.push_back({std::string(kSignalNames[i]), &log.signals[i], log.gap_of({static_cast<Signal>(i)})});
    }
  }
  for (const auto& [name, values] : log.extra) {
    out.push_back({"extra_" + name, &values, {}});
  }
  return out;
}

void finish(std::ofstream& out, const std::string& file) {
  out.close();
  if (!out) {
    throw InputError(file, 0, "", "cannot be written");
  }
}

}  // namespace

void write_csv(const FlightLog& log, const std::string& file) {
  std::ofstream out(file);
  const std::vector<Column> columns = columns_of(log);
  const std::vector<Flight> parts = log.parts();
  const std::size_t pauses =
      std::accumulate(parts.begin(), parts.end(), log.size,
                      [](std::size_t left, const Flight& part) { return left - (part.end - part.begin); });
  const bool has_gaps = std::count(log.gap.begin(), log.gap.end(), 1) > static_cast<std::ptrdiff_t>(pauses);
  out << "t_s";
  for (const Column& column : columns) {
    out << "," << column.name;
  }
  out << (has_gaps ? ",gap\n" : "\n");
  for (const Flight& part : parts) {
    for (std::size_t k = part.begin; k < part.end; ++k) {
      // Fifteen digits: a clock may count from 1970, and nine digits would resolve only ten seconds of it.
      out << printed("%.15g", part.start_s + static_cast<double>(k - part.begin) * log.period_s);
      for (const Column& column : columns) {
        const bool sampled = k >= column.gap.size() || column.gap[k] == 0;
        out << "," << (sampled ? printed("%.9g", (*column.values)[k]) : "");
      }
      out << (has_gaps ? (log.gap[k] != 0 ? ",1\n" : ",0\n") : "\n");
    }
  }
  finish(out, file);
}

void write_column_map(const FlightLog& log, const std::string& file) {
  std::ofstream out(file);
  out << "time = \"t_s\"\n[signals]\n";
  for (std::size_t i = 0; i < kSignals; ++i) {
    if (!log.signals[i].empty()) {
      out << kSignalNames[i] << " = { column = \"" << kSignalNames[i] << "\" }\n";
    }
  }
  if (!log.extra.empty()) {
    out << "[extra]\n";
    for (const auto& [name, values] : log.extra) {
      out << '"' << name << "\" = { column = \"extra_" << name << "\" }\n";
    }
  }
  finish(out, file);
}

}  // namespace m100::lab::logs
