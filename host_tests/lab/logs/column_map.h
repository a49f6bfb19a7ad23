// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>

#include "host_tests/lab/logs/signal.h"

namespace m100::lab::logs {

/// The column of a signal in a log: canonical = scale * (raw + offset).
struct ColumnRef {
  std::string column;
  double offset = 0;
  double scale = 1;
  std::string sequence;  ///< column of the stream's own message counter; empty: the reader finds it, or there is none
  std::string time;      ///< column of the stream's own clock; empty: the map's clock
  long line = 0;         ///< of the map file, for messages
};

/// The convention of a log's world and body axes.
enum class Frame { kNwuFlu, kNedFrd };

/// Describes how to read a log of any origin (TOML). Keys: frame ("nwu_flu", also for any other world with z up, or
/// "ned_frd": every signal that has a direction is rotated), time (a name, or {column, offset, scale}), [signals] with
/// the canonical names, [extra] with free names; an entry is a column name or {column, offset, scale, sequence, time}.
struct ColumnMap {
  std::string file;
  Frame frame = Frame::kNwuFlu;
  ColumnRef time;
  std::array<std::optional<ColumnRef>, kSignals> signals;
  std::map<std::string, ColumnRef> extra;
};

/// @throws InputError naming file, line and key: not TOML, an unknown or missing key, a wrong type, a scale of zero.
ColumnMap read_column_map(const std::string& file);

/// Reads a column map from text; `file` is used in messages only. @throws InputError as read_column_map() does.
ColumnMap parse_column_map(std::string_view text, const std::string& file);

}  // namespace m100::lab::logs
