// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/plot/html.h"

#include <cctype>
#include <filesystem>
#include <fstream>
#include <utility>

#include "firmware/companion/version.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/plot/svg.h"

namespace m100::lab::plot {
namespace {

constexpr const char* kStyle = R"(<style>
body{font-family:sans-serif;max-width:960px;margin:2em auto;padding:0 1em;color:#222;background:#fff;line-height:1.45}
h1{font-size:1.5em;border-bottom:2px solid #0072b2;padding-bottom:.25em}h2{font-size:1.2em;margin-top:1.8em}
table{border-collapse:collapse;margin:.8em 0;display:block;overflow-x:auto;font-size:.9em}th,td{padding:.25em .6em;border-bottom:1px solid #ddd;text-align:left}
th{background:#f3f6f9}td.n{text-align:right;white-space:nowrap;font-variant-numeric:tabular-nums}
td.missed{background:#fbeee5;color:#a33c00;font-weight:bold;white-space:nowrap}td.missed::before{content:"\25B2  "}
.box{padding:.7em 1em;border-left:6px solid;margin:1em 0;font-size:1.05em}
.good{border-color:#009e73;background:#eaf7f2}.warn{border-color:#e69f00;background:#fdf5e4}
.bad{border-color:#d55e00;background:#fbeee5}
figure{margin:1.2em 0}figure svg{max-width:100%;height:auto}figcaption{color:#555;font-size:.92em}
p,li,h1,h2,.box{overflow-wrap:anywhere}
@media(max-width:900px){body{margin:1em auto}figure{overflow-x:auto}figure svg{max-width:none}
table,figure{background:linear-gradient(to right,#fff 1.2em,transparent 2.4em) local,
linear-gradient(to left,#fff 1.2em,transparent 2.4em) right local,linear-gradient(to right,#9aa,transparent .8em),
linear-gradient(to left,#9aa,transparent .8em) right;background-repeat:no-repeat;background-size:2.4em 100%,2.4em 100%,.8em 100%,.8em 100%}
th{background:none;border-bottom:2px solid #9aa}}
@media(max-width:500px){th,td{padding:.25em .3em}}
</style>)";

bool looks_like_a_number(const std::string& cell) {
  return !cell.empty() && (std::isdigit(static_cast<unsigned char>(cell[0])) != 0 ||
                           ((cell[0] == '-' || cell[0] == '+') && cell.size() > 1 &&
                            std::isdigit(static_cast<unsigned char>(cell[1])) != 0));
}

std::string table_cell(const std::string& cell, bool missed) {
  const std::string look = std::string(looks_like_a_number(cell) ? "n" : "") + (missed ? " missed" : "");
  return "<td" + (look.empty() ? "" : " class=\"" + look + "\"") + ">" + escape(cell) + "</td>";
}

}  // namespace

Page::Page(std::string title) : title_(std::move(title)) {}

void Page::heading(const std::string& words) { body_ += "<h2>" + escape(words) + "</h2>\n"; }

void Page::paragraph(const std::string& words) { body_ += "<p>" + escape(words) + "</p>\n"; }

void Page::verdict(const std::string& words, const std::string& kind) {
  body_ += "<div class=\"box " + kind + "\">" + escape(words) + "</div>\n";
}

void Page::table(const std::vector<std::vector<std::string>>& rows, const Cells& missed) {
  body_ += "<table>\n";
  for (std::size_t r = 0; r < rows.size(); ++r) {
    body_ += "<tr>";
    for (std::size_t c = 0; c < rows[r].size(); ++c) {
      body_ += r == 0 ? "<th>" + escape(rows[r][c]) + "</th>" : table_cell(rows[r][c], missed.contains({r, c}));
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

void Page::figure(const std::string& svg, const std::string& caption) {
  body_ += "<figure>\n" + svg + "<figcaption>" + escape(caption) + "</figcaption></figure>\n";
}

std::string Page::html() const {
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><title>" +
         escape(title_) + "</title>" + kStyle + "</head><body>\n<h1>" + escape(title_) + "</h1>\n<p>m100-lab " +
         escape(companion::version()) + "</p>" + kHeadEnds + "\n" + body_ + "</body></html>\n";
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
