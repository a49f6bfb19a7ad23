// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace m100::lab::logs {

/// One line of a column map. In a column, `<Type>` stands for the first topic of that type.
struct MapEntry {
  std::string signal;
  std::string column;
  std::string more{};  ///< offset and scale, as the map writes them
};
/// Lines that are used together or not at all; skipped if an earlier group has given the same signals.
struct Group {
  std::string provides;  ///< keyword of the signals given: later groups with the same one are skipped
  std::vector<MapEntry> lines;
};
struct Dialect {
  std::string name;
  std::string known_by;  ///< a column by which the dialect is recognised
  std::string time;
  std::string frame;
  std::vector<Group> groups;
  std::vector<MapEntry> extra;
};

/// The programs whose logs are recognised by their columns.
std::vector<Dialect> dialects();

}  // namespace m100::lab::logs
