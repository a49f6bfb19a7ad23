// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace m100::lab::plot {

/// Colours that colour-blind readers can distinguish, also in print (Okabe and Ito).
inline constexpr const char* kBlack = "#333333";
inline constexpr const char* kBlue = "#0072b2";
inline constexpr const char* kOrange = "#d55e00";
inline constexpr const char* kGreen = "#009e73";
inline constexpr const char* kGrey = "#9a9a9a";

/// A curve; NaN in y breaks it. x must not decrease. Curves of more points than pixels are drawn as their envelope.
struct Curve {
  std::string name;  ///< for the legend; empty: not in it
  std::vector<double> x;
  std::vector<double> y;
  std::string color = kBlue;
  double width = 1.4;
  bool dashed = false;
};

/// A range of x, shaded behind the curves, e.g. the validation part.
struct Span {
  double from = 0.0;
  double to = 0.0;
  std::string label;
};

/// A figure with one pair of axes.
struct Figure {
  std::string title;
  std::string x_label;
  std::string y_label;
  std::vector<Curve> lines{};
  std::vector<Span> spans{};
  std::vector<std::pair<double, std::string>> levels{};  ///< horizontal marks: value, label
  std::optional<std::pair<double, double>> x_range{};
  std::optional<std::pair<double, double>> y_range{};
  bool equal_axes = false;  ///< one metre in x is one metre in y (paths seen from above)
  double width = 860.0;
  double height = 280.0;
};
std::string svg(const Figure& figure);

/// A horizontal bar; bars are drawn in their given order.
struct Bar {
  std::string label;
  double value = 0.0;
  std::string note;  ///< text after the bar
  std::string color = kBlue;
};
struct BarChart {
  std::string title;
  std::string x_label;
  std::vector<Bar> bars;
  double width = 860.0;
};
std::string svg(const BarChart& chart);

/// One row per parameter: the interval as a line, the value as a dot, and the numbers as text. All rows share one scale
/// in per cent of the value, as wide as the widest interval but at most +-50 %; longer intervals are cut at the edge.
/// If the value is zero, the scale is in per cent of the larger end.
struct IntervalRow {
  std::string label;
  double value = 0.0;
  double low = 0.0;
  double high = 0.0;
};
struct IntervalChart {
  std::string title;
  std::vector<IntervalRow> rows;
  double width = 860.0;
};
std::string svg(const IntervalChart& chart);

/// A confusion matrix: counts by row (true effect) and column (answer); on the diagonal the names agree.
struct Matrix {
  std::string title;
  std::vector<std::string> rows;
  std::vector<std::string> columns;
  std::vector<std::vector<int>> counts;
};
std::string svg(const Matrix& matrix);

/// A number as text: three significant digits, without exponent if possible.
std::string number(double value);
/// Text with <, >, & and quotes escaped.
std::string escape(const std::string& text);

}  // namespace m100::lab::plot
