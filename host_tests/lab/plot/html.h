// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace m100::lab::plot {

using Cells = std::set<std::pair<std::size_t, std::size_t>>;  ///< row and column of a table; the header is row 0

/// Marks where the content of a page's body begins: after the heading and the line that names the program.
inline constexpr const char* kHeadEnds = "<!-- head ends -->";

struct Figure;
struct BarChart;
struct HeatMap;
struct IntervalChart;

/// A self-contained page: one HTML file that needs no other file and no network. It names the version of the program
/// that made it. If dygraphs is installed where the page is made, the figures can be zoomed and read off; on paper and
/// without the library they are static drawings.
class Page {
 public:
  explicit Page(std::string title);

  void heading(const std::string& words);
  void paragraph(const std::string& words);
  /// A coloured box for the main sentence. kind: "good", "warn" or "bad".
  void verdict(const std::string& words, const std::string& kind);
  /// The page's answer: its parts ("Asked", "Missing in the model", ...) in reading order, each with its sentences;
  /// empty parts are left out. What is added until end_answer() is drawn beside it. @param kind as for verdict().
  using Answer = std::vector<std::pair<std::string, std::string>>;
  void begin_answer(const Answer& parts, const std::string& kind);
  void end_answer() { end_grid(); }
  /// The first row is the header. Cells that look like numbers are right-aligned.
  /// @param missed cells that miss their goal: marked by colour and by a triangle.
  void table(const std::vector<std::vector<std::string>>& rows, const Cells& missed = {});
  void list(const std::vector<std::string>& items);
  /// A list of links: the words and the address of each.
  void links(const std::vector<std::pair<std::string, std::string>>& items);
  /// A figure with a caption: a wide drawing, one for narrow screens, and the data for zooming in the browser.
  void figure(const Figure& figure, const std::string& caption);
  void figure(const BarChart& chart, const std::string& caption);
  void figure(const HeatMap& map, const std::string& caption);
  void figure(const IntervalChart& chart, const std::string& caption);
  /// A number in large print, with its name and one line that explains it.
  struct Tile {
    std::string name, value, note;
  };
  void tiles(const std::vector<Tile>& tiles);
  /// What is added until end_grid() is drawn side by side where the screen is wide enough.
  void begin_grid() { body_ += "<div class=\"grid\">\n"; }
  void end_grid() { body_ += "</div>\n"; }
  /// Appends HTML unchanged, e.g. another page's body().
  void raw(const std::string& html) { body_ += html; }

  const std::string& body() const { return body_; }
  std::string html() const;
  /// Creates the folder if needed. Errors: InputError naming the file.
  void write(const std::string& path) const;

 private:
  void boxed(const std::string& html, const std::string& caption);

  std::string title_;
  std::string body_;
};

}  // namespace m100::lab::plot
