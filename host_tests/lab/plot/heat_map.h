// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace m100::lab::plot {

/// A table of coloured cells, each with its number in words: good is blue, bad is orange, in steps of lightness that
/// also tell them apart in print.
struct HeatMap {
  std::string title;
  std::vector<std::string> rows;
  std::vector<std::string> columns;
  std::vector<std::vector<double>> values;      ///< row by column; NaN: an empty cell
  std::vector<std::vector<std::string>> words;  ///< what stands in the cell
  double good = 1.0;
  double bad = 0.0;  ///< values beyond both ends have the colour of the end
};
std::string svg(const HeatMap& map);

}  // namespace m100::lab::plot
