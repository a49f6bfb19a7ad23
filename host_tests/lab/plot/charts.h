// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "host_tests/lab/plot/svg.h"

// Charts made of HTML tables and boxes: they fit into any width, and a narrow screen shows their rows as blocks.
namespace m100::lab::plot {

/// A horizontal bar; bars are drawn in their given order.
struct Bar {
  std::string label;
  double value = 0.0;
  std::string note{};  ///< text after the bar
  std::string color = kBlue;
};
struct BarChart {
  std::string title;
  std::string x_label;
  std::vector<Bar> bars{};
};
std::string html(const BarChart& chart);

/// One row per parameter: the interval as a line, the value as a dot, the believed value as a square, and the numbers
/// as text. All rows share one scale in per cent of the value, as wide as the widest needs but at most +-55 %; what
/// lies beyond is drawn at the edge. If the value is zero, the scale is in per cent of the larger end.
struct IntervalRow {
  std::string label;
  double value = 0.0;
  double low = 0.0;
  double high = 0.0;
  double believed = std::numeric_limits<double>::quiet_NaN();  ///< NaN: none
  std::string color = kBlue;
};
struct IntervalChart {
  std::string title;
  std::vector<IntervalRow> rows{};
};
std::string html(const IntervalChart& chart);

/// A table of coloured cells, each with a text, and the scale of its colours. Good is blue and bad is orange, with
/// different lightness so that they differ in print too.
struct HeatMap {
  std::string title;
  std::vector<std::string> rows{};
  std::vector<std::string> columns{};
  std::vector<std::vector<double>> values{};      ///< row by column; NaN: an empty cell
  std::vector<std::vector<std::string>> words{};  ///< text of the cell
  double good = 1.0;
  double bad = 0.0;          ///< values beyond `good` or `bad` have the colour of that end
  std::string good_words{};  ///< at the end of the scale; empty: the number
  std::string bad_words{};
};
std::string html(const HeatMap& map);

}  // namespace m100::lab::plot
