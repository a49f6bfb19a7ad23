// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/column_map.h"

#include <cmath>

#include "firmware/companion/files/text/suggestion.h"
#include "firmware/companion/files/text/toml_text.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/printable.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab::logs {
namespace {

constexpr std::array<std::string_view, 5> kColumnKeys{"column", "offset", "scale", "sequence", "time"};
constexpr std::array<std::string_view, 4> kMapKeys{"frame", "time", "signals", "extra"};

long line_of(const toml::node& node) { return static_cast<long>(node.source().begin.line); }

double number(const toml::node& node, const std::string& file, const std::string& key) {
  const auto value = node.value<double>();
  if (!value || !std::isfinite(*value)) {
    throw InputError(file, line_of(node), key, "must be a finite number");
  }
  return *value;
}

std::string text_of(const toml::node& node, const std::string& file, const std::string& key) {
  const auto value = node.value<std::string>();
  if (!node.is_string() || value->empty()) {
    throw InputError(file, line_of(node), key, "must be the name of a column");
  }
  return *value;
}

ColumnRef column_ref(const toml::node& node, const std::string& file, const std::string& key) {
  ColumnRef ref;
  ref.line = line_of(node);
  const toml::table* table = node.as_table();
  if (table == nullptr) {
    ref.column = text_of(node, file, key);
    return ref;
  }
  for (const auto& [name, value] : *table) {
    const std::string part = key + "." + std::string(name.str());
    if (name == "column") {
      ref.column = text_of(value, file, part);
    } else if (name == "offset") {
      ref.offset = number(value, file, part);
    } else if (name == "scale") {
      ref.scale = number(value, file, part);
    } else if (name == "sequence") {
      ref.sequence = text_of(value, file, part);
    } else if (name == "time") {
      ref.time = text_of(value, file, part);
    } else {
      throw InputError(file, line_of(value), part,
                       "unknown key (known: column, offset, scale, sequence, time)" +
                           companion::did_you_mean(name.str(), kColumnKeys));
    }
  }
  if (ref.column.empty()) {
    throw InputError(file, ref.line, key, "names no column");
  }
  if (ref.scale == 0) {
    throw InputError(file, ref.line, key + ".scale", "must not be zero");
  }
  return ref;
}

const toml::table& section(const toml::node& node, const std::string& file, const std::string& key) {
  if (!node.is_table()) {
    throw InputError(file, line_of(node), key, "must be a table");
  }
  return *node.as_table();
}

void read_signals(const toml::table& table, ColumnMap& map) {
  for (const auto& [name, value] : table) {
    const auto signal = signal_of(name.str());
    if (!signal) {
      throw InputError(map.file, line_of(value), std::string(name.str()),
                       "is not a canonical signal" + companion::did_you_mean(name.str(), kSignalNames));
    }
    map.signals[static_cast<std::size_t>(*signal)] = column_ref(value, map.file, std::string(name.str()));
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

Frame frame_of(const toml::node& value, const std::string& file) {
  const std::string word = value.value<std::string>().value_or("");
  if (word != "nwu_flu" && word != "ned_frd") {
    throw InputError(file, line_of(value), "frame", "must be \"nwu_flu\" or \"ned_frd\"");
  }
  return word == "ned_frd" ? Frame::kNedFrd : Frame::kNwuFlu;
}

void read_extra(const toml::table& columns, ColumnMap& map) {
  for (const auto& [name, column] : columns) {
    map.extra[std::string(name.str())] = column_ref(column, map.file, "extra." + std::string(name.str()));
  }
}

/// Checks that nothing is missing and nothing is given twice.
void check_whole(const toml::table& root, const ColumnMap& map) {
  check_quaternion(map, Signal::kAttitudeQw, Signal::kAttitudeRoll, 3);
  check_quaternion(map, Signal::kCommandQw, Signal::kCommandRoll, 2);
  if (map.time.column.empty()) {
    throw InputError(map.file, 0, "time", "is missing: which column is the clock?");
  }
  if (root["signals"].as_table() == nullptr || root["signals"].as_table()->empty()) {
    throw InputError(map.file, 0, "signals", "is missing or empty");
  }
}

}  // namespace

ColumnMap parse_column_map(std::string_view text, const std::string& file) {
  toml::table root;
  try {
    root = companion::parse_toml(text);
  } catch (const companion::TomlTextError& error) {
    throw InputError(file, error.line, "", printable(error.what(), 200));
  }
  ColumnMap map;
  map.file = file;
  for (const auto& [name, value] : root) {
    const std::string key(name.str());
    if (key == "time") {
      map.time = column_ref(value, file, key);
    } else if (key == "frame") {
      map.frame = frame_of(value, file);
    } else if (key == "signals") {
      read_signals(section(value, file, key), map);
    } else if (key == "extra") {
      read_extra(section(value, file, key), map);
    } else {
      throw InputError(
          file, line_of(value), key,
          "unknown key (known: frame, time, [signals], [extra])" + companion::section_meant(key, kMapKeys));
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
