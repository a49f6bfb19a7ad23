// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/plot/svg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <sstream>
#include <string_view>

#include "host_tests/lab/printed.h"

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

/// The range with a margin above and below, a share of its size; a single value stands in the middle; 0 to 1 if empty.
Range padded(Range range, double air) {
  if (!(range.low <= range.high)) {
    return {.low = 0.0, .high = 1.0};
  }
  const double largest = std::max(std::abs(range.low), std::abs(range.high));
  // A narrower range cannot hold ticks that differ.
  const double margin = range.size() > 1e-9 * largest ? air * range.size() : largest > 0.0 ? 0.5 * largest : 0.5;
  return {.low = range.low - margin, .high = range.high + margin};
}

/// The given range, or else the padded range of the data.
Range shown(const std::optional<std::pair<double, double>>& given, const Range& data, double air) {
  return given ? padded({.low = given->first, .high = given->second}, 0.0) : padded(data, air);
}

/// The smallest step of 1, 2 or 5 times a power of ten with at most `count` steps in the range, but no larger than half
/// of the range: an axis has two ticks at least.
double tick_step(const Range& range, int count) {
  const double raw = range.size() / count;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = power;
  for (const double multiple : {2.0, 5.0, 10.0}) {
    step = step < raw && multiple * power <= 0.5 * range.size() ? multiple * power : step;
  }
  return step;
}

std::string tick_label(double value, double step) {
  const int digits = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 6);
  return printed("%.*f", digits, std::abs(value) < step / 1e6 ? 0.0 : value);
}

void text(std::ostream& out, double x, double y, const std::string& words, const char* anchor,
          const std::string& extra = "") {
  out << "<text x=\"" << x << "\" y=\"" << y << "\" text-anchor=\"" << anchor << "\" fill=\"#222\" " << extra << '>'
      << escape(words) << "</text>\n";
}

/// The mapping from data to pixels.
struct Sheet {
  double left, top, width, height;
  Range x, y;
  double px(double value) const { return left + width * (value - x.low) / x.size(); }
  double py(double value) const { return top + height * (1.0 - (value - y.low) / y.size()); }
};

/// @param maps whether an attribute gives the mapping from data to pixels, for a script that draws the cursor.
std::string open_svg(double width, double height, const Sheet& s, bool maps) {
  std::ostringstream out;
  out << "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " << width << ' ' << height << "\" width=\"" << width
      << "\" height=\"" << height << "\" font-family=\"sans-serif\" font-size=\"" << kFont << "\"";
  if (maps) {
    out << " data-map=\"" << s.px(0.0) << ' ' << s.px(1.0) - s.px(0.0) << ' ' << s.py(0.0) << ' '
        << s.py(1.0) - s.py(0.0) << "\"";
  }
  out << ">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  return out.str();
}

double y_tick_step(const Sheet& s) { return tick_step(s.y, std::max(2, static_cast<int>(s.height / 37.0))); }

void draw_grid(std::ostream& out, const Sheet& s) {
  const double x_step = tick_step(s.x, std::max(2, static_cast<int>(s.width / 85.0)));
  for (double v = std::ceil(s.x.low / x_step) * x_step; v <= s.x.high + 1e-9 * x_step; v += x_step) {
    out << "<line x1=\"" << s.px(v) << "\" x2=\"" << s.px(v) << "\" y1=\"" << s.top << "\" y2=\"" << s.top + s.height
        << "\" stroke=\"#e6e6e6\"/>\n";
    text(out, s.px(v), s.top + s.height + 16, tick_label(v, x_step), "middle");
  }
  const double y_step = y_tick_step(s);
  for (double v = std::ceil(s.y.low / y_step) * y_step; v <= s.y.high + 1e-9 * y_step; v += y_step) {
    out << "<line y1=\"" << s.py(v) << "\" y2=\"" << s.py(v) << "\" x1=\"" << s.left << "\" x2=\"" << s.left + s.width
        << "\" stroke=\"#e6e6e6\"/>\n";
    text(out, s.left - 6, s.py(v) + 4, tick_label(v, y_step), "end");
  }
  out << "<rect x=\"" << s.left << "\" y=\"" << s.top << "\" width=\"" << s.width << "\" height=\"" << s.height
      << "\" fill=\"none\" stroke=\"#888\"/>\n";
}

void draw_line(std::ostream& out, const Curve& line, const Sheet& s) {
  out << "<path fill=\"none\" stroke=\"" << line.color << "\" stroke-width=\"" << line.width
      << "\" stroke-linejoin=\"round\" stroke-linecap=\"round\"" << (line.dashed ? " stroke-dasharray=\"6 4\"" : "")
      << " d=\"";
  bool pen_down = false;
  const Curve drawn = thinned(line, static_cast<std::size_t>(4.0 * s.width));
  for (std::size_t i = 0; i < drawn.x.size(); ++i) {
    if (!std::isfinite(drawn.y[i])) {
      pen_down = false;
      continue;
    }
    // The line of no length shows a point that has no neighbours.
    out << printed(pen_down ? "L%.1f %.1f" : "M%.1f %.1fh0", s.px(drawn.x[i]), s.py(drawn.y[i]));
    pen_down = true;
  }
  out << "\"/>\n";
}

constexpr double kLegendRow = 18.0;

/// Draws the names of the curves in as many rows as they need. @returns the number of rows. @param out may be null.
int draw_legend(std::ostream* out, const std::vector<Curve>& lines, double left, double right, double y) {
  double x = left;
  int rows = 1;
  for (const Curve& line : lines) {
    if (line.name.empty()) {
      continue;
    }
    const double width = 27 + kGlyph * static_cast<double>(line.name.size()) + 22;
    if (x > left && x + width - 22 > right) {
      x = left;
      ++rows;
    }
    if (out != nullptr) {
      const double row = y + kLegendRow * (rows - 1);
      *out << "<line x1=\"" << x << "\" x2=\"" << x + 22 << "\" y1=\"" << row - 4 << "\" y2=\"" << row - 4
           << "\" stroke=\"" << line.color << "\" stroke-width=\"2.5\""
           << (line.dashed ? " stroke-dasharray=\"6 4\"" : "") << "/>\n";
      text(*out, x + 27, row, line.name, "start");
    }
    x += width;
  }
  return rows;
}

Sheet sheet_of(const Figure& figure, bool bare) {
  const double left = bare ? 48.0 : 62.0;
  const double top = (bare ? 8.0 : 28.0) + kLegendRow * draw_legend(nullptr, figure.lines, left, figure.width, 0.0);
  Sheet s{.left = left,
          .top = top,
          .width = figure.width - left - 18.0,
          .height = figure.height - top - 46.0,
          .x = {},
          .y = {}};
  for (const Curve& line : figure.lines) {
    std::for_each(line.x.begin(), line.x.end(), [&](double v) { s.x.take(v); });
    std::for_each(line.y.begin(), line.y.end(), [&](double v) { s.y.take(v); });
  }
  for (const auto& level : figure.levels) {
    s.y.take(level.first);
  }
  s.x = shown(figure.x_range, s.x, 0.0);
  s.y = shown(figure.y_range, s.y, 0.06);
  const std::size_t longest =
      std::max(tick_label(s.y.low, y_tick_step(s)).size(), tick_label(s.y.high, y_tick_step(s)).size());
  const double wider =
      std::max(0.0, 6.0 + 7.0 * static_cast<double>(longest) - left);  // 7 px a character, 6 to the axis
  s.left += wider;
  s.width -= wider;
  if (figure.equal_axes) {
    const double metre = std::min(s.width / s.x.size(), s.height / s.y.size());
    const double x_air = (s.width / metre - s.x.size()) / 2;
    const double y_air = (s.height / metre - s.y.size()) / 2;
    s.x = {s.x.low - x_air, s.x.high + x_air};
    s.y = {s.y.low - y_air, s.y.high + y_air};
  }
  return s;
}

void draw_spans(std::ostream& out, const std::vector<Span>& spans, const Sheet& s) {
  for (const Span& span : spans) {
    const double from = s.px(std::clamp(span.from, s.x.low, s.x.high));
    const double to = s.px(std::clamp(span.to, s.x.low, s.x.high));
    out << "<rect x=\"" << from << "\" y=\"" << s.top << "\" width=\"" << to - from << "\" height=\"" << s.height
        << "\" fill=\"" << span.color << "\"/>\n";
    if (to - from > kGlyph * static_cast<double>(span.label.size())) {
      text(out, (from + to) / 2, s.top + 13, span.label, "middle", "fill-opacity=\"0.65\"");
    }
  }
}

void draw_levels(std::ostream& out, const std::vector<std::pair<double, std::string>>& levels, const Sheet& s) {
  for (const auto& [level, label] : levels) {
    out << "<line x1=\"" << s.left << "\" x2=\"" << s.left + s.width << "\" y1=\"" << s.py(level) << "\" y2=\""
        << s.py(level) << "\" stroke=\"" << kGrey << "\" stroke-dasharray=\"3 3\"/>\n";
    text(out, s.left + s.width - 4, s.py(level) - 4, label, "end");
  }
}

}  // namespace

std::string joined(const std::vector<std::string>& texts, const std::string& between) {
  std::string out;
  for (const std::string& text : texts) {
    out += (out.empty() ? "" : between) + text;
  }
  return out;
}

std::string escape(const std::string& words) {
  constexpr std::string_view kSpecial = "<>&\"";
  constexpr std::array kEntities{"&lt;", "&gt;", "&amp;", "&quot;"};
  std::string out;
  for (const char c : words) {
    if (c == '>' && out.ends_with('-')) {  // the browser would break "->" in two
      out.replace(out.size() - 1, 1, "→");
      continue;
    }
    const std::size_t at = kSpecial.find(c);
    out += at < kSpecial.size() ? kEntities[at] : std::string(1, c);
  }
  return out;
}

std::string number(double value) {
  if (!std::isfinite(value)) {
    return "–";
  }
  const double size = std::abs(value);
  if (size > 0.0 && size < 1e-3) {
    return printed("%.2e", value);
  }
  return printed("%.*f", size == 0.0 ? 0 : std::clamp(2 - static_cast<int>(std::floor(std::log10(size))), 0, 5), value);
}

std::string percent(double share) {
  const double tenths = std::round(1000.0 * share);
  if (!std::isfinite(share) || tenths == 0.0) {
    return std::isfinite(share) ? "0 %" : "–";
  }
  return printed("%+.*f %%", std::abs(tenths) < 100.0 ? 1 : 0, tenths / 10.0);
}

Curve in_order(const Curve& curve) {
  const std::size_t count = std::min(curve.x.size(), curve.y.size());
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < count; ++i) {
    if (std::isfinite(curve.x[i])) {
      order.push_back(i);
    }
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return curve.x[a] < curve.x[b]; });
  Curve out = curve;
  out.x.clear();
  out.y.clear();
  for (const std::size_t i : order) {
    if (!out.x.empty() && curve.x[i] - out.x.back() > curve.max_step) {
      out.x.push_back(out.x.back());
      out.y.push_back(std::nan(""));
    }
    out.x.push_back(curve.x[i]);
    out.y.push_back(curve.y[i]);
  }
  return out;
}

Curve thinned(const Curve& curve, std::size_t count) {
  const std::size_t size = std::min(curve.x.size(), curve.y.size());
  const std::size_t group = std::max<std::size_t>(1, 2 * size / std::max<std::size_t>(count, 1));
  Curve out = curve;
  out.x.clear();
  out.y.clear();
  const auto keep = [&](std::size_t i) {
    out.x.push_back(curve.x[i]);
    out.y.push_back(curve.y[i]);
  };
  for (std::size_t begin = 0; begin < size; begin += group) {
    const auto first = curve.y.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto last = first + static_cast<std::ptrdiff_t>(std::min(group, size - begin));
    const auto index = [&](auto found) { return static_cast<std::size_t>(found - curve.y.begin()); };
    const auto broken = std::find_if(first, last, [](double y) { return !std::isfinite(y); });
    if (broken != last) {
      keep(index(broken));
      continue;
    }
    const std::size_t low = index(std::min_element(first, last));
    const std::size_t high = index(std::max_element(first, last));
    keep(std::min(low, high));
    if (low != high) {
      keep(std::max(low, high));
    }
  }
  return out;
}

std::string svg(const Figure& given, bool bare) {
  Figure figure = given;
  if (!figure.equal_axes) {
    std::transform(figure.lines.begin(), figure.lines.end(), figure.lines.begin(), in_order);
  }
  const Sheet s = sheet_of(figure, bare);
  std::ostringstream out;
  out << open_svg(figure.width, figure.height, s, bare);
  if (!bare) {
    text(out, s.left, 16, figure.title, "start", "font-weight=\"bold\"");
  }
  draw_legend(&out, figure.lines, s.left, figure.width, bare ? 16 : 36);
  draw_spans(out, figure.spans, s);
  draw_grid(out, s);
  draw_levels(out, figure.levels, s);
  // One page holds many figures: the clip needs a name that no other figure has.
  const std::string clip = "c" + std::to_string(std::hash<std::string>{}(figure.title + figure.y_label + out.str()));
  out << "<clipPath id=\"" << clip << "\"><rect x=\"" << s.left << "\" y=\"" << s.top << "\" width=\"" << s.width
      << "\" height=\"" << s.height << "\"/></clipPath>\n<g clip-path=\"url(#" << clip << ")\">\n";
  for (const Curve& line : figure.lines) {
    draw_line(out, line, s);
  }
  out << "</g>\n";
  text(out, s.left + s.width / 2, figure.height - 10, figure.x_label, "middle");
  if (!bare) {
    const double y_middle = s.top + s.height / 2;
    text(out, 14, y_middle, figure.y_label, "middle", printed("transform=\"rotate(-90 14 %g)\"", y_middle));
  }
  out << "</svg>\n";
  return out.str();
}

}  // namespace m100::lab::plot
