// SPDX-License-Identifier: BSD-3-Clause
// m100-lab reference: prints the keys and words that the programs read, as JSON, for the guide's reference pages.
#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>

#include "host_tests/lab/reference/tables.h"
#include "host_tests/lab/subcommands.h"

namespace m100::lab {
namespace {

void print_references() {
  nlohmann::ordered_json pages;
  for (const reference::Table& table : reference::tables()) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const reference::Row& row : table.rows) {
      rows.push_back({{"section", row.section}, {"key", row.key}, {"cells", row.cells}});
    }
    pages[table.page] = {{"columns", table.columns}, {"rows", rows}};
  }
  std::cout << pages.dump(1) << "\n";
}

}  // namespace

void add_reference(CLI::App& lab) {
  lab.add_subcommand("reference",
                     "print every key and word that the programs read, with unit, range and default, as JSON")
      ->callback(print_references);
}

}  // namespace m100::lab
