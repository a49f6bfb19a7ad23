// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/plot/heat_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "host_tests/lab/plot/svg.h"

namespace m100::lab::plot {
namespace {

constexpr double kGlyph_px = 7.0;
constexpr double kBoldGlyph_px = 7.5;
constexpr double kCellHeight_px = 24.0;

/// A colour of the scale from orange through near white to blue.
std::string colour(double share) {
  constexpr std::array<std::array<double, 3>, 3> kEnds{{{213, 94, 0}, {247, 243, 238}, {0, 114, 178}}};
  const double at = 2.0 * std::clamp(share, 0.0, 1.0);
  const std::size_t from = at < 1.0 ? 0 : 1;
  const double way = at - static_cast<double>(from);
  std::ostringstream out;
  out << "rgb(";
  for (std::size_t i = 0; i < 3; ++i) {
    out << (i > 0 ? "," : "") << std::lround(kEnds[from][i] + way * (kEnds[from + 1][i] - kEnds[from][i]));
  }
  out << ")";
  return out.str();
}

void text(std::ostringstream& out, double x, double y, const std::string& words, const char* anchor,
          const std::string& more = "") {
  out << "<text x=\"" << x << "\" y=\"" << y << "\" text-anchor=\"" << anchor << "\" " << more << ">" << escape(words)
      << "</text>\n";
}

std::size_t longest(const std::vector<std::string>& words, std::size_t least) {
  for (const std::string& word : words) {
    least = std::max(least, word.size());
  }
  return least;
}

}  // namespace

std::string svg(const HeatMap& map) {
  std::size_t widest = longest(map.columns, 6);
  for (const std::vector<std::string>& row : map.words) {
    widest = longest(row, widest);
  }
  const double cell = 12.0 + kGlyph_px * static_cast<double>(widest);
  const double left = 20.0 + kGlyph_px * static_cast<double>(longest(map.rows, 4));
  const double top = 48.0;
  const double titled = 24.0 + kBoldGlyph_px * static_cast<double>(map.title.size());
  const double width = std::max(titled, left + cell * static_cast<double>(map.columns.size()) + 12.0);
  const double height = top + kCellHeight_px * static_cast<double>(map.rows.size()) + 12.0;
  std::ostringstream out;
  out << "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " << width << ' ' << height << "\" width=\"" << width
      << "\" font-family=\"sans-serif\" font-size=\"12\">\n";
  text(out, 12, 16, map.title, "start", "font-weight=\"bold\"");
  for (std::size_t c = 0; c < map.columns.size(); ++c) {
    text(out, left + cell * (static_cast<double>(c) + 0.5), top - 8, map.columns[c], "middle");
  }
  for (std::size_t r = 0; r < map.rows.size(); ++r) {
    const double y = top + kCellHeight_px * static_cast<double>(r);
    text(out, left - 8, y + 16, map.rows[r], "end");
    for (std::size_t c = 0; c < map.columns.size(); ++c) {
      if (std::isnan(map.values[r][c])) {
        continue;
      }
      const double share = (map.values[r][c] - map.bad) / (map.good - map.bad);
      const double x = left + cell * static_cast<double>(c);
      out << "<rect x=\"" << x << "\" y=\"" << y << "\" width=\"" << cell - 1 << "\" height=\"" << kCellHeight_px - 1
          << "\" fill=\"" << colour(share) << "\"/>\n";
      const bool dark = share < 0.15 || share > 0.85;
      text(out, x + 0.5 * cell, y + 16, map.words[r][c], "middle", dark ? "fill=\"#ffffff\"" : "fill=\"#333333\"");
    }
  }
  out << "</svg>\n";
  return out.str();
}

}  // namespace m100::lab::plot
