// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace m100::lab::reference {

/// One key or word from the code's own table.
struct Row {
  std::string section;  ///< "[fence]"; the heading on the page
  std::string key;
  std::vector<std::string> cells;  ///< the page's columns between the key and its meaning
};

/// One reference page of the guide: the part of it that the code knows.
struct Table {
  std::string page;                  ///< file name without its ending
  std::vector<std::string> columns;  ///< headings of the cells
  std::vector<Row> rows;
};

/// The keys of every file and the words of every script that the programs read, from the tables with which they read
/// them. Throws std::logic_error if a written vehicle file has a section that is not listed here.
std::vector<Table> tables();

}  // namespace m100::lab::reference
