// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
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
inline constexpr const char* kPurple = "#cc79a7";
inline constexpr const char* kGrey = "#9a9a9a";

/// A curve; NaN in y breaks it. With more than four points per pixel of width, its envelope is drawn.
struct Curve {
  std::string name;  ///< for the legend; empty: not in it
  std::vector<double> x{};
  std::vector<double> y{};
  std::string color = kBlue;
  double width = 1.4;
  bool dashed = false;
  double max_step = std::numeric_limits<double>::infinity();  ///< a longer step in x is a gap and breaks the curve
  std::vector<double> t_s{};  ///< of a path: the time of each point, so that the cursor of linked figures shows on it
};
/// The curve with increasing x and broken at its gaps: the parts of a log may come in any order.
Curve in_order(const Curve& curve);
/// About `count` points: the smallest and the largest y of each group of neighbours, in their order; gaps are kept.
Curve thinned(const Curve& curve, std::size_t count);

/// A range of x, shaded behind the curves, e.g. the validation part.
struct Span {
  double from = 0.0;
  double to = 0.0;
  std::string label;
  std::string color = "#fff3d6";
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
  bool equal_axes = false;  ///< a path: x in any order, and one metre in x is one metre in y
  double width = 860.0;
  double height = 280.0;
  std::string link{};  ///< figures of a page with the same word share cursor and zoom; empty: none
};
/// @param bare without title and label of y, which the page then shows beside the drawing.
std::string svg(const Figure& figure, bool bare = false);

/// A number as text: three significant digits, more from 1000 on; with an exponent below 0.001.
std::string number(double value);
/// A change as text: +12 %, -3.4 %, 0 %. @param share 0.12 is 12 %.
std::string percent(double share);
/// The texts one after the other, with `between` between them.
std::string joined(const std::vector<std::string>& texts, const std::string& between);
/// Text with <, >, & and double quotes escaped; "->" becomes an arrow.
std::string escape(const std::string& text);

}  // namespace m100::lab::plot
