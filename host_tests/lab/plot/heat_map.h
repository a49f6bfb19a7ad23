// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace m100::lab::plot {

/// A table of coloured cells, each with a text. Good is blue and bad is orange, with different lightness so that they
/// differ in print too.
struct HeatMap {
  std::string title;
  std::vector<std::string> rows;
  std::vector<std::string> columns;
  std::vector<std::vector<double>> values;      ///< row by column; NaN: an empty cell
  std::vector<std::vector<std::string>> words;  ///< text of the cell
  double good = 1.0;
  double bad = 0.0;  ///< values beyond `good` or `bad` have the colour of that end
};
std::string svg(const HeatMap& map);

}  // namespace m100::lab::plot
