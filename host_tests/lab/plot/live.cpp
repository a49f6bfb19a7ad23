// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/plot/live.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "firmware/companion/files/text/json.h"
#include "host_tests/lab/plot/page_files.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::plot {
namespace {

constexpr std::size_t kMaxPoints = 8000;

std::string text_of(const std::string& folder, const char* name) {
  std::ifstream file(folder + "/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// The words as a JSON string that cannot end the script element that holds it.
std::string quoted(const std::string& words) {
  std::string out;
  for (const char c : Json(words).dump()) {
    out += c == '<' ? std::string("\\u003c") : std::string(1, c);
  }
  return out;
}

/// A JSON array of the values with `digits` significant digits; null for a value that is not finite.
std::string numbers(const std::vector<double>& values, int digits) {
  std::string out = "[";
  for (const double value : values) {
    out += (out.size() > 1 ? "," : "") + (std::isfinite(value) ? printed("%.*g", digits, value) : "null");
  }
  return out + "]";
}

std::string range(const std::optional<std::pair<double, double>>& given) {
  return given ? numbers({given->first, given->second}, 7) : "null";
}

}  // namespace

std::string live_data(const Figure& figure) {
  std::string out = "{\"x\":" + quoted(figure.x_label) + ",\"y\":" + quoted(figure.y_label) +
                    ",\"link\":" + quoted(figure.link) + ",\"path\":" + (figure.equal_axes ? "true" : "false") +
                    ",\"height\":" + numbers({figure.height}, 5) + ",\"xrange\":" + range(figure.x_range) +
                    ",\"yrange\":" + range(figure.y_range) + ",\"series\":[";
  std::vector<double> last;
  for (std::size_t i = 0; i < figure.lines.size(); ++i) {
    const Curve& line = figure.lines[i];
    const Curve drawn = figure.equal_axes ? line : thinned(in_order(line), kMaxPoints);
    out += std::string(i > 0 ? "," : "") + "{\"name\":" + quoted(line.name) + ",\"color\":" + quoted(line.color) +
           ",\"width\":" + numbers({line.width}, 3) + ",\"dashed\":" + (line.dashed ? "true" : "false");
    if (!figure.equal_axes) {
      out += ",\"x\":" + (i > 0 && drawn.x == last ? std::string("null") : numbers(drawn.x, 7)) +
             ",\"y\":" + numbers(drawn.y, 5);
    } else if (!line.t_s.empty()) {
      out += ",\"t\":" + numbers(line.t_s, 7) + ",\"x\":" + numbers(line.x, 5) + ",\"y\":" + numbers(line.y, 5);
    }
    out += "}";
    last = drawn.x;
  }
  out += "],\"spans\":[";
  for (std::size_t i = 0; i < figure.spans.size(); ++i) {
    const Span& span = figure.spans[i];
    out += std::string(i > 0 ? "," : "") + "[" + numbers({span.from, span.to}, 7) + "," + quoted(span.label) + "," +
           quoted(span.color) + "]";
  }
  out += "],\"levels\":[";
  for (std::size_t i = 0; i < figure.levels.size(); ++i) {
    out += std::string(i > 0 ? "," : "") + "[" + numbers({figure.levels[i].first}, 5) + "," +
           quoted(figure.levels[i].second) + "]";
  }
  return out + "]}";
}

std::string live_head() {
  const char* const given = std::getenv("M100_DYGRAPHS");
  const std::string folder = given != nullptr ? given : "/usr/share/javascript/dygraphs";
  const std::string library = text_of(folder, "dygraph.min.js");
  if (library.find("dygraphs") == std::string::npos) {
    return "";
  }
  return "<style>" + text_of(folder, "dygraph.min.css") + "</style>\n<script>" + library + "</script>\n<script>" +
         kLiveScript + "</script>\n";
}

}  // namespace m100::lab::plot
