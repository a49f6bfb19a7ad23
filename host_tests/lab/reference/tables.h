// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace m100::lab::reference {

/// One key or word as the code's own table has it.
struct Row {
  std::string section;  ///< "[fence]"; what the page has as a heading
  std::string key;
  std::vector<std::string> cells;  ///< as the page's columns between the key and its meaning
};

/// One reference page of the guide: everything on it that the code knows.
struct Table {
  std::string page;                  ///< file name without its ending
  std::vector<std::string> columns;  ///< heads of the cells
  std::vector<Row> rows;
};

/// The keys of every file and the words of every script that the programs read, from the tables by which they read
/// them. Throws std::logic_error where a file has a section that is not listed here.
std::vector<Table> tables();

}  // namespace m100::lab::reference
