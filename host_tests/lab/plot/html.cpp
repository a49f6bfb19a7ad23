// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/plot/html.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iterator>
#include <sstream>
#include <utility>

#include "firmware/companion/version.h"
#include "host_tests/lab/plot/charts.h"
#include "host_tests/lab/plot/live.h"
#include "host_tests/lab/plot/page_files.h"
#include "host_tests/lab/plot/svg.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab::plot {
namespace {

/// Width of the drawing for a telephone of 400 px, without the margins of the page and a scroll bar.
constexpr double kNarrow_px = 345.0;

constexpr const char* kHint =
    R"(<span class="hint" hidden> &middot; Figures: drag zooms, shift and drag moves, a double click shows all; a name switches its curve off.</span>)";

bool looks_like_a_number(const std::string& cell) {
  return !cell.empty() && (std::isdigit(static_cast<unsigned char>(cell[0])) != 0 ||
                           ((cell[0] == '-' || cell[0] == '+') && cell.size() > 1 &&
                            std::isdigit(static_cast<unsigned char>(cell[1])) != 0));
}

/// Whether the cell has a word of more than 40 letters, which the browser may break anywhere.
bool has_long_word(const std::string& cell) {
  std::istringstream words(cell);
  return std::any_of(std::istream_iterator<std::string>(words), std::istream_iterator<std::string>(),
                     [](const std::string& word) { return word.size() > 40; });
}

std::string table_cell(const std::string& cell, const std::string& head, bool missed) {
  const std::string look = std::string(looks_like_a_number(cell) ? "n"
                                       : has_long_word(cell)     ? "long"
                                                                 : "") +
                           (missed ? " missed" : "");
  return "<td" + (look.empty() ? "" : " class=\"" + look + "\"") + " data-head=\"" + escape(head) + "\">" +
         escape(cell) + "</td>";
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
  constexpr std::size_t kFew = 2;  // columns that fit on a telephone side by side
  body_ += rows.front().size() > kFew ? "<table class=\"many\">\n" : "<table>\n";
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
         escape(title_) + "</title><style>" + kPageStyle + "</style>" + head + "</head><body>\n<h1>" + escape(title_) +
         "</h1>\n<p class=\"made\">m100-lab " + escape(companion::version()) + kHint + "</p>" + kHeadEnds + "\n" +
         body_ + "</body></html>\n";
}

void Page::write(const std::string& path) const {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (!folder.empty()) {
    std::filesystem::create_directories(folder, error);
  }
  write_whole_file(path, html());
}

}  // namespace m100::lab::plot
