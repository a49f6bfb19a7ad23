// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/column_map.h"

#include <cmath>

#include "firmware/companion/files/text/suggestion.h"
#include "firmware/companion/files/text/toml_text.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab::logs {
namespace {

constexpr std::array<std::string_view, 5> kColumnKeys{"column", "offset", "scale", "sequence", "time"};
constexpr std::array<std::string_view, 4> kMapKeys{"frame", "time", "signals", "extra"};

using companion::TomlNode;

double number(const TomlNode& node) {
  if (!node.is(TomlNode::Kind::kNumber) || !std::isfinite(node.number())) {
    node.refuse("must be a finite number");
  }
  return node.number();
}

const std::string& text_of(const TomlNode& node) {
  if (node.text().empty()) {
    node.refuse("must be the name of a column");
  }
  return node.text();
}

ColumnRef column_ref(const TomlNode& node) {
  ColumnRef ref;
  ref.line = node.line();
  if (!node.is_table()) {
    ref.column = text_of(node);
    return ref;
  }
  for (const TomlNode& value : node.entries()) {
    const std::string& name = value.key();
    if (name == "column") {
      ref.column = text_of(value);
    } else if (name == "offset") {
      ref.offset = number(value);
    } else if (name == "scale") {
      ref.scale = number(value);
    } else if (name == "sequence") {
      ref.sequence = text_of(value);
    } else if (name == "time") {
      ref.time = text_of(value);
    } else {
      value.refuse("unknown key (known: column, offset, scale, sequence, time)" +
                   companion::did_you_mean(name, kColumnKeys));
    }
  }
  if (ref.column.empty()) {
    node.refuse("names no column");
  }
  if (ref.scale == 0) {
    node.refuse_without("scale", "must not be zero");
  }
  return ref;
}

void read_signals(const TomlNode& table, ColumnMap& map) {
  for (const TomlNode& value : table.entries()) {
    const auto signal = signal_of(value.key());
    if (!signal) {
      value.refuse("is not a canonical signal" + companion::did_you_mean(value.key(), kSignalNames));
    }
    map.signals[static_cast<std::size_t>(*signal)] = column_ref(value);
  }
}

/// Checks that all four parts or none are given, and that the angles that they determine are not given as well.
void check_quaternion(const ColumnMap& map, Signal first, Signal angle, int angles) {
  const auto given = [&](Signal signal) { return map.signals[static_cast<std::size_t>(signal)].has_value(); };
  int parts = 0;
  for (int i = 0; i < 4; ++i) {
    parts += given(offset(first, i)) ? 1 : 0;
  }
  for (int i = 0; i < 4 && parts > 0; ++i) {
    if (!given(offset(first, i))) {
      throw InputError(map.file, 0, std::string(name_of(offset(first, i))), "is missing: a quaternion has four parts");
    }
  }
  for (int i = 0; i < angles && parts > 0; ++i) {
    if (given(offset(angle, i))) {
      throw InputError(map.file, map.signals[static_cast<std::size_t>(offset(angle, i))]->line,
                       std::string(name_of(offset(angle, i))), "is given by the quaternion already: keep one of them");
    }
  }
}

Frame frame_of(const TomlNode& value) {
  if (value.text() != "nwu_flu" && value.text() != "ned_frd") {
    value.refuse("must be \"nwu_flu\" or \"ned_frd\"");
  }
  return value.text() == "ned_frd" ? Frame::kNedFrd : Frame::kNwuFlu;
}

/// Checks that nothing is missing and nothing is given twice.
void check_whole(const TomlNode& root, const ColumnMap& map) {
  check_quaternion(map, Signal::kAttitudeQw, Signal::kAttitudeRoll, 3);
  check_quaternion(map, Signal::kCommandQw, Signal::kCommandRoll, 2);
  if (map.time.column.empty()) {
    throw InputError(map.file, 0, "time", "is missing: which column is the clock?");
  }
  if (root.get("signals") == nullptr || root.get("signals")->entries().empty()) {
    throw InputError(map.file, 0, "signals", "is missing or empty");
  }
}

}  // namespace

ColumnMap parse_column_map(std::string_view text, const std::string& file) {
  const TomlNode root = companion::parse_toml(text, file);
  ColumnMap map;
  map.file = file;
  for (const TomlNode& value : root.entries()) {
    const std::string& key = value.key();
    if (key == "time") {
      map.time = column_ref(value);
    } else if (key == "frame") {
      map.frame = frame_of(value);
    } else if (key == "signals") {
      read_signals(value.table(), map);
    } else if (key == "extra") {
      for (const TomlNode& column : value.table().entries()) {
        map.extra[column.key()] = column_ref(column);
      }
    } else {
      value.refuse("unknown key (known: frame, time, [signals], [extra])" + companion::section_meant(key, kMapKeys));
    }
  }
  check_whole(root, map);
  return map;
}

ColumnMap read_column_map(const std::string& file) {
  constexpr std::uintmax_t kMaxBytes = 1U << 20U;
  return parse_column_map(whole_file(file, kMaxBytes), file);
}

}  // namespace m100::lab::logs
