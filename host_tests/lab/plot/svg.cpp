// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/plot/svg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <sstream>

namespace m100::lab::plot {
namespace {

constexpr double kFont = 12.0;
constexpr double kGlyph = 6.6;  ///< mean width of a character at kFont

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void take(double value) {
    if (std::isfinite(value)) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  double size() const { return high - low; }
};

/// A range that is never empty or a single value, with a margin above and below.
Range padded(Range range, double air) {
  if (!(range.low <= range.high)) {
    return {.low = 0.0, .high = 1.0};
  }
  const double size = range.size() > 0.0 ? range.size() : std::max(1e-9, std::abs(range.low));
  return {.low = range.low - air * size, .high = range.high + air * size};
}

/// Steps of 1, 2 or 5 times a power of ten, about `count` of them.
double tick_step(const Range& range, int count) {
  const double raw = range.size() / count;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double multiple : {1.0, 2.0, 5.0}) {
    if (multiple * power >= raw) {
      return multiple * power;
    }
  }
  return 10.0 * power;
}

std::string tick_label(double value, double step) {
  const int digits = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 6);
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.*f", digits, std::abs(value) < step / 1e6 ? 0.0 : value);
  return text.data();
}

std::string open_svg(double width, double height) {
  std::ostringstream out;
  out << "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " << width << ' ' << height << "\" width=\"" << width
      << "\" height=\"" << height << "\" font-family=\"sans-serif\" font-size=\"" << kFont << "\">\n"
      << "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  return out.str();
}

void text(std::ostream& out, double x, double y, const std::string& words, const char* anchor,
          const std::string& extra = "") {
  out << "<text x=\"" << x << "\" y=\"" << y << "\" text-anchor=\"" << anchor << "\" fill=\"#222\" " << extra << '>'
      << escape(words) << "</text>\n";
}

/// The mapping from data to the sheet.
struct Sheet {
  double left, top, width, height;
  Range x, y;
  double px(double value) const { return left + width * (value - x.low) / x.size(); }
  double py(double value) const { return top + height * (1.0 - (value - y.low) / y.size()); }
};

void draw_grid(std::ostream& out, const Sheet& s) {
  const double x_step = tick_step(s.x, 9);
  for (double v = std::ceil(s.x.low / x_step) * x_step; v <= s.x.high + 1e-9 * x_step; v += x_step) {
    out << "<line x1=\"" << s.px(v) << "\" x2=\"" << s.px(v) << "\" y1=\"" << s.top << "\" y2=\"" << s.top + s.height
        << "\" stroke=\"#e6e6e6\"/>\n";
    text(out, s.px(v), s.top + s.height + 16, tick_label(v, x_step), "middle");
  }
  const double y_step = tick_step(s.y, 5);
  for (double v = std::ceil(s.y.low / y_step) * y_step; v <= s.y.high + 1e-9 * y_step; v += y_step) {
    out << "<line y1=\"" << s.py(v) << "\" y2=\"" << s.py(v) << "\" x1=\"" << s.left << "\" x2=\"" << s.left + s.width
        << "\" stroke=\"#e6e6e6\"/>\n";
    text(out, s.left - 6, s.py(v) + 4, tick_label(v, y_step), "end");
  }
  out << "<rect x=\"" << s.left << "\" y=\"" << s.top << "\" width=\"" << s.width << "\" height=\"" << s.height
      << "\" fill=\"none\" stroke=\"#888\"/>\n";
}

/// At most two points per pixel column: the smallest and the largest, in their order.
std::vector<std::pair<double, double>> thinned(const Curve& line, const Sheet& s) {
  std::vector<std::pair<double, double>> points;
  const std::size_t count = std::min(line.x.size(), line.y.size());
  const std::size_t bucket = std::max<std::size_t>(1, count / static_cast<std::size_t>(2.0 * s.width));
  for (std::size_t begin = 0; begin < count; begin += bucket) {
    const std::size_t end = std::min(count, begin + bucket);
    std::size_t low = begin;
    std::size_t high = begin;
    bool broken = false;
    for (std::size_t i = begin; i < end; ++i) {
      broken = broken || !std::isfinite(line.y[i]);
      low = line.y[i] < line.y[low] ? i : low;
      high = line.y[i] > line.y[high] ? i : high;
    }
    if (broken) {
      points.emplace_back(line.x[begin], std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    points.emplace_back(line.x[std::min(low, high)], line.y[std::min(low, high)]);
    if (low != high) {
      points.emplace_back(line.x[std::max(low, high)], line.y[std::max(low, high)]);
    }
  }
  return points;
}

void draw_line(std::ostream& out, const Curve& line, const Sheet& s) {
  out << "<path fill=\"none\" stroke=\"" << line.color << "\" stroke-width=\"" << line.width
      << "\" stroke-linejoin=\"round\"" << (line.dashed ? " stroke-dasharray=\"6 4\"" : "") << " d=\"";
  bool pen_down = false;
  std::array<char, 64> step{};
  for (const auto& [x, y] : thinned(line, s)) {
    if (!std::isfinite(y)) {
      pen_down = false;
      continue;
    }
    std::snprintf(step.data(), step.size(), "%c%.1f %.1f", pen_down ? 'L' : 'M', s.px(x), s.py(y));
    out << step.data();
    pen_down = true;
  }
  out << "\"/>\n";
}

void draw_legend(std::ostream& out, const std::vector<Curve>& lines, double left, double y) {
  double x = left;
  for (const Curve& line : lines) {
    if (line.name.empty()) {
      continue;
    }
    out << "<line x1=\"" << x << "\" x2=\"" << x + 22 << "\" y1=\"" << y - 4 << "\" y2=\"" << y - 4 << "\" stroke=\""
        << line.color << "\" stroke-width=\"2.5\"" << (line.dashed ? " stroke-dasharray=\"6 4\"" : "") << "/>\n";
    text(out, x + 27, y, line.name, "start");
    x += 27 + kGlyph * static_cast<double>(line.name.size()) + 22;
  }
}

Sheet sheet_of(const Figure& figure) {
  Sheet s{.left = 62, .top = 46, .width = figure.width - 80, .height = figure.height - 92, .x = {}, .y = {}};
  for (const Curve& line : figure.lines) {
    std::for_each(line.x.begin(), line.x.end(), [&](double v) { s.x.take(v); });
    std::for_each(line.y.begin(), line.y.end(), [&](double v) { s.y.take(v); });
  }
  for (const auto& level : figure.levels) {
    s.y.take(level.first);
  }
  s.x = figure.x_range ? Range{figure.x_range->first, figure.x_range->second} : padded(s.x, 0.0);
  s.y = figure.y_range ? Range{figure.y_range->first, figure.y_range->second} : padded(s.y, 0.06);
  if (figure.equal_axes) {
    const double metre = std::min(s.width / s.x.size(), s.height / s.y.size());
    const double x_air = (s.width / metre - s.x.size()) / 2;
    const double y_air = (s.height / metre - s.y.size()) / 2;
    s.x = {s.x.low - x_air, s.x.high + x_air};
    s.y = {s.y.low - y_air, s.y.high + y_air};
  }
  return s;
}

/// The ends of an interval as shares of its value.
std::pair<double, double> shares(const IntervalRow& row) {
  const double size = std::abs(row.value) > 0.0 ? std::abs(row.value) : std::max(std::abs(row.low), std::abs(row.high));
  return size > 0.0 ? std::pair{(row.low - row.value) / size, (row.high - row.value) / size} : std::pair{0.0, 0.0};
}

/// A round number of per cent that includes every interval, at most 50.
double widest_percent(const IntervalChart& chart) {
  constexpr std::array kRound{1.0, 2.0, 5.0, 10.0, 20.0, 50.0};
  double widest = 0.0;
  for (const IntervalRow& row : chart.rows) {
    const auto [low, high] = shares(row);
    widest = std::max({widest, -100.0 * low, 100.0 * high});
  }
  const auto* const found = std::find_if(kRound.begin(), kRound.end(), [&](double round) { return round >= widest; });
  return found == kRound.end() ? kRound.back() : *found;
}

}  // namespace

std::string escape(const std::string& words) {
  std::string out;
  for (const char c : words) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string number(double value) {
  std::array<char, 32> text{};
  if (!std::isfinite(value)) {
    return "–";
  }
  const double size = std::abs(value);
  if (size > 0.0 && size < 1e-3) {
    std::snprintf(text.data(), text.size(), "%.2e", value);
  } else {
    const int digits = size == 0.0 ? 0 : std::clamp(2 - static_cast<int>(std::floor(std::log10(size))), 0, 5);
    std::snprintf(text.data(), text.size(), "%.*f", digits, value);
  }
  return text.data();
}

std::string svg(const Figure& figure) {
  const Sheet s = sheet_of(figure);
  std::ostringstream out;
  out << open_svg(figure.width, figure.height);
  text(out, s.left, 16, figure.title, "start", "font-weight=\"bold\"");
  draw_legend(out, figure.lines, s.left, 36);
  for (const Span& span : figure.spans) {
    const double from = s.px(std::clamp(span.from, s.x.low, s.x.high));
    const double to = s.px(std::clamp(span.to, s.x.low, s.x.high));
    out << "<rect x=\"" << from << "\" y=\"" << s.top << "\" width=\"" << to - from << "\" height=\"" << s.height
        << "\" fill=\"#fff3d6\"/>\n";
    text(out, (from + to) / 2, s.top + 13, span.label, "middle", "fill-opacity=\"0.65\"");
  }
  draw_grid(out, s);
  for (const auto& [level, label] : figure.levels) {
    out << "<line x1=\"" << s.left << "\" x2=\"" << s.left + s.width << "\" y1=\"" << s.py(level) << "\" y2=\""
        << s.py(level) << "\" stroke=\"" << kGrey << "\" stroke-dasharray=\"3 3\"/>\n";
    text(out, s.left + s.width - 4, s.py(level) - 4, label, "end");
  }
  // One page holds many figures: the clip needs a name that no other figure has.
  const std::string clip = "c" + std::to_string(std::hash<std::string>{}(figure.title + figure.y_label + out.str()));
  out << "<clipPath id=\"" << clip << "\"><rect x=\"" << s.left << "\" y=\"" << s.top << "\" width=\"" << s.width
      << "\" height=\"" << s.height << "\"/></clipPath>\n<g clip-path=\"url(#" << clip << ")\">\n";
  for (const Curve& line : figure.lines) {
    draw_line(out, line, s);
  }
  out << "</g>\n";
  text(out, s.left + s.width / 2, figure.height - 10, figure.x_label, "middle");
  const double y_middle = s.top + s.height / 2;
  std::ostringstream turned;
  turned << "transform=\"rotate(-90 14 " << y_middle << ")\"";
  text(out, 14, y_middle, figure.y_label, "middle", turned.str());
  out << "</svg>\n";
  return out.str();
}

std::string svg(const BarChart& chart) {
  std::size_t longest = 4;
  Range range;
  range.take(0.0);
  for (const Bar& bar : chart.bars) {
    longest = std::max(longest, bar.label.size());
    range.take(bar.value);
  }
  const double row = 21.0;
  const double height = 62.0 + row * static_cast<double>(chart.bars.size());
  const double left = 16.0 + kGlyph * static_cast<double>(longest);
  Sheet s{.left = left,
          .top = 28,
          .width = chart.width - left - 190,
          .height = height - 62,
          .x = range.size() > 0.0 ? range : Range{0.0, 1.0},
          .y = {0, 1}};
  std::ostringstream out;
  out << open_svg(chart.width, height);
  text(out, 12, 16, chart.title, "start", "font-weight=\"bold\"");
  const double step = tick_step(s.x, 6);
  for (double v = std::ceil(s.x.low / step) * step; v <= s.x.high + 1e-9 * step; v += step) {
    out << "<line x1=\"" << s.px(v) << "\" x2=\"" << s.px(v) << "\" y1=\"" << s.top << "\" y2=\"" << s.top + s.height
        << "\" stroke=\"#e6e6e6\"/>\n";
    text(out, s.px(v), s.top + s.height + 15, tick_label(v, step), "middle");
  }
  double y = s.top + 3;
  for (const Bar& bar : chart.bars) {
    const double from = s.px(std::min(0.0, bar.value));
    const double to = s.px(std::max(0.0, bar.value));
    out << "<rect x=\"" << from << "\" y=\"" << y << "\" width=\"" << std::max(0.5, to - from)
        << "\" height=\"14\" fill=\"" << bar.color << "\"/>\n";
    text(out, left - 6, y + 11, bar.label, "end");
    text(out, to + 6, y + 11, bar.note, "start");
    y += row;
  }
  text(out, s.left + s.width / 2, height - 6, chart.x_label, "middle");
  out << "</svg>\n";
  return out.str();
}

std::string svg(const IntervalChart& chart) {
  std::size_t longest = 4;
  for (const IntervalRow& row : chart.rows) {
    longest = std::max(longest, row.label.size());
  }
  const double left = 18.0 + kGlyph * static_cast<double>(longest);
  const double words = 250.0;
  const double scale = widest_percent(chart);
  const double height = 54.0 + 26.0 * static_cast<double>(chart.rows.size());
  std::ostringstream out;
  out << open_svg(chart.width, height);
  text(out, 12, 16, chart.title, "start", "font-weight=\"bold\"");
  const Sheet s{.left = left,
                .top = 40,
                .width = chart.width - left - words,
                .height = 1,
                .x = {-1.1 * scale, 1.1 * scale},
                .y = {0, 1}};
  for (const double tick : {-scale, -0.5 * scale, 0.0, 0.5 * scale, scale}) {
    text(out, s.px(tick), 36, (tick > 0.0 ? "+" : "") + number(tick) + " %", "middle");
    out << "<line x1=\"" << s.px(tick) << "\" x2=\"" << s.px(tick) << "\" y1=\"42\" y2=\"" << height - 8
        << "\" stroke=\"#e6e6e6\"/>\n";
  }
  double y = 60;
  for (const IntervalRow& row : chart.rows) {
    const auto [low, high] = shares(row);
    const double from = std::max(-1.1 * scale, 100.0 * low);
    const double to = std::min(1.1 * scale, 100.0 * high);
    out << "<line x1=\"" << s.left << "\" x2=\"" << s.left + s.width << "\" y1=\"" << y << "\" y2=\"" << y
        << "\" stroke=\"#e6e6e6\"/>\n<line x1=\"" << s.px(from) << "\" x2=\"" << s.px(to) << "\" y1=\"" << y
        << "\" y2=\"" << y << "\" stroke=\"" << kBlue << "\" stroke-width=\"4\"/>\n<circle cx=\"" << s.px(0.0)
        << "\" cy=\"" << y << "\" r=\"5\" fill=\"" << kOrange << "\"/>\n";
    text(out, left - 8, y + 4, row.label, "end");
    text(out, s.left + s.width + 10, y + 4,
         number(row.value) + "   [" + number(row.low) + ", " + number(row.high) + "]", "start");
    y += 26;
  }
  out << "</svg>\n";
  return out.str();
}

namespace {

constexpr double kCell = 30.0;

/// One row of a matrix: a square for each count, whose fill grows with the count's share of the row.
void draw_counts(std::ostringstream& out, const Matrix& matrix, std::size_t r, double left, double y) {
  int total = 0;
  for (const int count : matrix.counts[r]) {
    total += count;
  }
  for (std::size_t c = 0; c < matrix.columns.size(); ++c) {
    const int count = matrix.counts[r][c];
    const double share = total > 0 ? static_cast<double>(count) / total : 0.0;
    const bool right = matrix.rows[r] == matrix.columns[c];
    const double x = left + kCell * static_cast<double>(c);
    out << "<rect x=\"" << x << "\" y=\"" << y << "\" width=\"" << kCell - 1 << "\" height=\"" << kCell - 1
        << "\" fill=\"" << (right ? kGreen : kOrange) << "\" fill-opacity=\"" << (count > 0 ? 0.15 + 0.75 * share : 0)
        << "\" stroke=\"#ddd\"/>\n";
    if (count > 0) {
      text(out, x + kCell / 2, y + 20, std::to_string(count), "middle");
    }
  }
}

}  // namespace

std::string svg(const Matrix& matrix) {
  std::size_t longest_row = 4;
  std::size_t longest_column = 4;
  for (const std::string& row : matrix.rows) {
    longest_row = std::max(longest_row, row.size());
  }
  for (const std::string& column : matrix.columns) {
    longest_column = std::max(longest_column, column.size());
  }
  const double left = 20.0 + kGlyph * static_cast<double>(longest_row);
  const double top = 34.0 + 0.75 * kGlyph * static_cast<double>(longest_column);
  const double width = left + kCell * static_cast<double>(matrix.columns.size()) + 90.0;
  const double height = top + kCell * static_cast<double>(matrix.rows.size()) + 12.0;
  std::ostringstream out;
  out << open_svg(width, height);
  text(out, 12, 16, matrix.title, "start", "font-weight=\"bold\"");
  for (std::size_t c = 0; c < matrix.columns.size(); ++c) {
    const double x = left + kCell * (static_cast<double>(c) + 0.6);
    std::ostringstream turned;
    turned << "transform=\"rotate(-48 " << x << ' ' << top - 6 << ")\"";
    text(out, x, top - 6, matrix.columns[c], "start", turned.str());
  }
  for (std::size_t r = 0; r < matrix.rows.size(); ++r) {
    const double y = top + kCell * static_cast<double>(r);
    text(out, left - 8, y + 20, matrix.rows[r], "end");
    draw_counts(out, matrix, r, left, y);
  }
  out << "</svg>\n";
  return out.str();
}

}  // namespace m100::lab::plot
