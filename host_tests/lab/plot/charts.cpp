// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/plot/charts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "host_tests/lab/printed.h"

namespace m100::lab::plot {
namespace {

using Color = std::array<double, 3>;

std::string title_of(const std::string& title) { return "<div class=\"title\">" + escape(title) + "</div>\n"; }

/// A colour of the scale from orange through near white to blue.
Color color_at(double share) {
  constexpr std::array<Color, 3> kEnds{{{213, 94, 0}, {247, 243, 238}, {0, 114, 178}}};
  const double at = 2.0 * std::clamp(share, 0.0, 1.0);
  const std::size_t from = at < 1.0 ? 0 : 1;
  Color out{};
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = std::round(kEnds[from][i] + (at - static_cast<double>(from)) * (kEnds[from + 1][i] - kEnds[from][i]));
  }
  return out;
}

/// Background, and white or dark text, whichever stands out more from it.
std::string style_at(double share) {
  const Color c = color_at(share);
  const double luminance = 0.299 * c[0] + 0.587 * c[1] + 0.114 * c[2];
  return printed("background:rgb(%g,%g,%g);color:%s", c[0], c[1], c[2], luminance < 128.0 ? "#fff" : "#222");
}

/// The ends of an interval and the believed value: differences from the value, divided by the value's size.
std::array<double, 3> shares(const IntervalRow& row) {
  const double size = std::abs(row.value) > 0.0 ? std::abs(row.value) : std::max(std::abs(row.low), std::abs(row.high));
  if (size <= 0.0) {
    return {0.0, 0.0, std::isnan(row.believed) ? row.believed : 0.0};
  }
  return {(row.low - row.value) / size, (row.high - row.value) / size, (row.believed - row.value) / size};
}

/// The least of 1, 2, 5, 10, 20, 50 % that includes every interval and believed value; 50 % if none does.
double widest_percent(const IntervalChart& chart) {
  constexpr std::array kRound{1.0, 2.0, 5.0, 10.0, 20.0, 50.0};
  double widest = 0.0;
  for (const IntervalRow& row : chart.rows) {
    for (const double share : shares(row)) {
      widest = std::isfinite(share) ? std::max(widest, 100.0 * std::abs(share)) : widest;
    }
  }
  const auto* const found = std::find_if(kRound.begin(), kRound.end(), [&](double round) { return round >= widest; });
  return found == kRound.end() ? kRound.back() : *found;
}

}  // namespace

std::string html(const BarChart& chart) {
  double low = 0.0;
  double high = 0.0;
  for (const Bar& bar : chart.bars) {
    low = std::min(low, bar.value);
    high = std::max(high, bar.value);
  }
  const double size = high > low ? high - low : 1.0;
  std::ostringstream out;
  out << title_of(chart.title) << "<div class=\"bars\">\n";
  for (const Bar& bar : chart.bars) {
    out << "<div><span>" << escape(bar.label)
        << "</span><span class=\"bar\"><i style=\"margin-left:" << 100.0 * (std::min(0.0, bar.value) - low) / size
        << "%;width:" << 100.0 * std::abs(bar.value) / size << "%;background:" << bar.color << "\"></i></span><span>"
        << escape(bar.note) << "</span></div>\n";
  }
  out << "</div><div class=\"axis\">" << escape(chart.x_label) << "</div>\n";
  return out.str();
}

std::string html(const IntervalChart& chart) {
  const double scale = widest_percent(chart);
  const auto at = [&](double share) { return 50.0 + 45.0 * std::clamp(100.0 * share / scale, -1.1, 1.1); };
  std::ostringstream out;
  out << title_of(chart.title) << "<div class=\"bars\">\n";
  for (const IntervalRow& row : chart.rows) {
    const auto [low, high, believed] = shares(row);
    out << "<div><span>" << escape(row.label) << "</span><span class=\"bar line\"><i style=\"left:" << at(low)
        << "%;width:" << at(high) - at(low) << "%;background:" << row.color << "\"></i>";
    if (std::isfinite(believed)) {
      out << "<s style=\"left:" << at(believed) << "%\"></s>";
    }
    out << "<b style=\"left:" << at(0.0) << "%;background:" << row.color << "\"></b></span><span>";
    if (std::isfinite(believed)) {
      out << number(row.believed) << " &rarr; ";
    }
    out << number(row.value) << " [" << number(row.low) << ", " << number(row.high) << "]</span></div>\n";
  }
  out << "</div><div class=\"axis\">the line is &plusmn;" << number(1.1 * scale) << " % of the value</div>\n";
  return out.str();
}

std::string html(const HeatMap& map) {
  std::ostringstream out;
  out << title_of(map.title) << "<table class=\"heat\">\n<tr><th></th>";
  for (const std::string& column : map.columns) {
    out << "<th>" << escape(column) << "</th>";
  }
  out << "</tr>\n";
  for (std::size_t r = 0; r < map.rows.size(); ++r) {
    out << "<tr><th>" << escape(map.rows[r]) << "</th>";
    for (std::size_t c = 0; c < map.columns.size(); ++c) {
      if (std::isnan(map.values[r][c])) {
        out << "<td class=\"none\"></td>";
        continue;
      }
      out << "<td data-head=\"" << escape(map.columns[c]) << "\" style=\""
          << style_at((map.values[r][c] - map.bad) / (map.good - map.bad)) << "\">" << escape(map.words[r][c])
          << "</td>";
    }
    out << "</tr>\n";
  }
  out << "</table><div class=\"scale\"><span>" << escape(map.bad_words.empty() ? number(map.bad) : map.bad_words)
      << "</span><i></i><span>" << escape(map.good_words.empty() ? number(map.good) : map.good_words)
      << "</span></div>\n";
  return out.str();
}

}  // namespace m100::lab::plot
