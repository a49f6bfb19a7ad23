// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/plot/html.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <utility>

#include "firmware/companion/version.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/plot/charts.h"
#include "host_tests/lab/plot/live.h"
#include "host_tests/lab/plot/svg.h"

namespace m100::lab::plot {
namespace {

constexpr const char* kStyle = R"(<style>
body{font-family:sans-serif;max-width:960px;margin:1.2em auto;padding:0 1em;color:#222;background:#fff;line-height:1.45}
.broad body{max-width:1240px}
h1{font-size:1.5em;border-bottom:2px solid #0072b2;padding-bottom:.25em;margin:.4em 0}h2{font-size:1.2em;margin-top:1.8em}
.made{color:#555;font-size:.85em;margin:.3em 0}
table{border-collapse:collapse;margin:.8em 0;font-size:.9em}th,td{padding:.25em .6em;border-bottom:1px solid #ddd;text-align:left}
th{background:#f3f6f9}td.n{text-align:right;white-space:nowrap;font-variant-numeric:tabular-nums}
td.missed{background:#fbeee5;color:#a33c00;font-weight:bold}td.missed::after{content:" \25B2"}
.box{padding:.7em 1em;border-left:6px solid;margin:.8em 0;font-size:1.05em}
.answer{margin:0;align-self:start;font-size:1em}.answer p{margin:.3em 0}
.good{border-color:#009e73;background:#eaf7f2}.warn{border-color:#e69f00;background:#fdf5e4}
.bad{border-color:#d55e00;background:#fbeee5}
figure{margin:1.2em 0;min-width:0}figure svg{max-width:100%;height:auto}figcaption{color:#555;font-size:.92em}
.title{font-weight:bold}.title span,.axis{font-weight:normal;color:#555;font-size:.9em}
p,li,h1,h2,.box,.title,.tight td{overflow-wrap:anywhere}
.narrow{display:none}.grid .narrow{display:block}.grid .wide{display:none}
.grid{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,340px),1fr));gap:.6em 1.4em}.grid figure{margin:.2em 0}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(150px,1fr));gap:.6em;margin:.8em 0}
.tiles div{background:#f3f6f9;padding:.4em .7em;overflow-wrap:anywhere}.tiles span{color:#555;font-size:.8em;display:block}.tiles b{font-size:1.15em}
.bars{display:grid;grid-template-columns:auto minmax(80px,1fr) auto;gap:.25em .6em;align-items:center;font-size:.85em}
.bars>div{display:contents}.bars span:first-child{text-align:right}.bar{position:relative;height:1em}
.bar i{display:block;height:100%;min-width:1px}.line{border-left:1px solid #ddd;border-right:1px solid #ddd;background:linear-gradient(#ddd,#ddd) 50%/100% 1px no-repeat}
.line>*{position:absolute;top:50%}.line i{height:4px;margin-top:-2px}.line b,.line s{width:10px;height:10px;margin:-5px 0 0 -5px}
.line b{border-radius:50%}.line s{border:2px solid #333;box-sizing:border-box}
.heat{border-collapse:separate;border-spacing:1px}.heat td{text-align:center;border:0}
.scale{display:flex;gap:.5em;align-items:center;font-size:.85em}.scale i{width:180px;height:.9em;background:linear-gradient(to right,rgb(213,94,0),rgb(247,243,238),rgb(0,114,178))}
.keys{display:flex;flex-wrap:wrap;gap:0 1em;font-size:.85em;min-height:1.5em}.keys label{cursor:pointer}
.keys i{display:inline-block;width:20px;margin:0 .3em .25em 0}.keys b{font-variant-numeric:tabular-nums}.keys>span{color:#555}
.live .static{display:none}.dygraph-xlabel{font-size:12px;color:#555}
@media(max-width:1000px){.many td{overflow-wrap:anywhere}}
@media(max-width:700px){body{margin:.6em auto}.wide{display:none}.narrow{display:block}
.bars{grid-template-columns:1fr}.bars>div{display:block;margin-bottom:.4em}.bars span{display:block}.bars span:first-child{text-align:left}
.many,.many tbody,.heat,.heat tbody{display:block}.many tr,.heat tr{display:block;border-bottom:2px solid #9aa;padding:.3em 0}
.many tr:first-child,.heat tr:first-child{display:none}.many td{display:flex;flex-wrap:wrap;justify-content:space-between;gap:0 1em;border:0;padding:.1em .3em;white-space:normal}
.many td:empty,.heat td.none{display:none}.many td:first-child{font-weight:bold;justify-content:flex-start}.many td::before{content:attr(data-head);color:#555;font-weight:normal;overflow-wrap:break-word}
.many td:first-child::before{content:none}.heat th{display:block}.heat td{display:inline-block;margin:1px}.heat td::before{content:attr(data-head) ": "}}
@media print{*{print-color-adjust:exact;-webkit-print-color-adjust:exact}.live .static{display:block}.plot,.keys,.hint{display:none}}
</style>)";

/// Width of the drawing for a telephone of 400 px, without the margins of the page and a scroll bar.
constexpr double kNarrow_px = 345.0;
/// Width inside of a page for a computer's screen that has no grid.
constexpr double kPage_px = 928.0;

constexpr const char* kHint =
    R"(<span class="hint" hidden> &middot; Figures: drag zooms, shift and drag moves, a double click shows all; a name switches its curve off.</span>)";

bool looks_like_a_number(const std::string& cell) {
  return !cell.empty() && (std::isdigit(static_cast<unsigned char>(cell[0])) != 0 ||
                           ((cell[0] == '-' || cell[0] == '+') && cell.size() > 1 &&
                            std::isdigit(static_cast<unsigned char>(cell[1])) != 0));
}

std::string table_cell(const std::string& cell, const std::string& head, bool missed) {
  const std::string look = std::string(looks_like_a_number(cell) ? "n" : "") + (missed ? " missed" : "");
  return "<td" + (look.empty() ? "" : " class=\"" + look + "\"") + " data-head=\"" + escape(head) + "\">" +
         escape(cell) + "</td>";
}

/// The least width of a table whose lines break at spaces only.
double unbroken_px(const std::vector<std::vector<std::string>>& rows) {
  constexpr double kLetter_px = 8.0;  // wide fonts need this for the letters of a cell
  constexpr double kPadding_px = 18.0;
  double sum = 0.0;
  for (std::size_t c = 0; c < rows.front().size(); ++c) {
    std::size_t longest = 0;
    for (const std::vector<std::string>& row : rows) {
      const std::string& cell = row.at(c);
      std::size_t begin = 0;
      for (std::size_t i = 0; i <= cell.size(); ++i) {
        const bool ends = i == cell.size() || (cell[i] == ' ' && !looks_like_a_number(cell));
        longest = ends ? std::max(longest, i - begin) : longest;
        begin = ends ? i + 1 : begin;
      }
    }
    sum += kPadding_px + kLetter_px * static_cast<double>(longest);
  }
  return sum;
}

}  // namespace

Page::Page(std::string title) : title_(std::move(title)) {}

void Page::heading(const std::string& words) { body_ += "<h2>" + escape(words) + "</h2>\n"; }

void Page::paragraph(const std::string& words) { body_ += "<p>" + escape(words) + "</p>\n"; }

void Page::verdict(const std::string& words, const std::string& kind) {
  body_ += "<div class=\"box " + kind + "\">" + escape(words) + "</div>\n";
}

void Page::begin_answer(const Answer& parts, const std::string& kind) {
  begin_grid();
  body_ += "<div class=\"box answer " + kind + "\">\n";
  for (const auto& [name, words] : parts) {
    body_ += words.empty() ? "" : "<p><b>" + escape(name) + ": </b>" + escape(words) + "</p>\n";
  }
  body_ += "</div>\n";
}

void Page::table(const std::vector<std::vector<std::string>>& rows, const Cells& missed) {
  const double width_px = unbroken_px(rows);
  body_ += width_px <= kNarrow_px ? "<table>\n"
           : width_px <= kPage_px ? "<table class=\"many\">\n"
                                  : "<table class=\"many tight\">\n";
  for (std::size_t r = 0; r < rows.size(); ++r) {
    body_ += "<tr>";
    for (std::size_t c = 0; c < rows[r].size(); ++c) {
      body_ += r == 0 ? "<th>" + escape(rows[r][c]) + "</th>"
                      : table_cell(rows[r][c], rows.front()[c], missed.contains({r, c}));
    }
    body_ += "</tr>\n";
  }
  body_ += "</table>\n";
}

void Page::list(const std::vector<std::string>& items) {
  body_ += "<ul>\n";
  for (const std::string& item : items) {
    body_ += "<li>" + escape(item) + "</li>\n";
  }
  body_ += "</ul>\n";
}

void Page::links(const std::vector<std::pair<std::string, std::string>>& items) {
  body_ += "<ul>\n";
  for (const auto& [words, address] : items) {
    body_ += "<li><a href=\"" + escape(address) + "\">" + escape(words) + "</a></li>\n";
  }
  body_ += "</ul>\n";
}

void Page::boxed(const std::string& html, const std::string& caption) {
  body_ += "<figure>\n" + html + "<figcaption>" + escape(caption) + "</figcaption></figure>\n";
}

void Page::figure(const Figure& figure, const std::string& caption) {
  Figure narrow = figure;
  narrow.width = kNarrow_px;
  boxed("<div class=\"title\">" + escape(figure.title) + " <span>" + escape(figure.y_label) +
            "</span></div>\n<div class=\"static\"><div class=\"wide\">" + svg(figure, true) +
            "</div><div class=\"narrow\">" + svg(narrow, true) + "</div></div>\n<script type=\"application/json\">" +
            live_data(figure) + "</script>\n",
        caption);
}

void Page::figure(const BarChart& chart, const std::string& caption) { boxed(plot::html(chart), caption); }
void Page::figure(const HeatMap& map, const std::string& caption) { boxed(plot::html(map), caption); }
void Page::figure(const IntervalChart& chart, const std::string& caption) { boxed(plot::html(chart), caption); }

void Page::tiles(const std::vector<Tile>& tiles) {
  body_ += "<div class=\"tiles\">\n";
  for (const Tile& tile : tiles) {
    body_ += "<div><span>" + escape(tile.name) + "</span><b>" + escape(tile.value) + "</b><span>" + escape(tile.note) +
             "</span></div>\n";
  }
  body_ += "</div>\n";
}

std::string Page::html() const {
  const bool is_wide = body_.find("<div class=\"grid\">") != std::string::npos;
  const std::string head = body_.find("type=\"application/json\"") != std::string::npos ? live_head() : "";
  return std::string("<!DOCTYPE html>\n<html lang=\"en\"") + (is_wide ? " class=\"broad\"" : "") +
         "><head><meta charset=\"utf-8\">"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><title>" +
         escape(title_) + "</title>" + kStyle + head + "</head><body>\n<h1>" + escape(title_) +
         "</h1>\n<p class=\"made\">m100-lab " + escape(companion::version()) + kHint + "</p>" + kHeadEnds + "\n" +
         body_ + "</body></html>\n";
}

void Page::write(const std::string& path) const {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (!folder.empty()) {
    std::filesystem::create_directories(folder, error);
  }
  std::ofstream file(path, std::ios::binary);
  file << html();
  file.flush();
  if (!file) {
    throw InputError(path, 0, "", "cannot be written");
  }
}

}  // namespace m100::lab::plot
