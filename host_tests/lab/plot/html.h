// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace m100::lab::plot {

using Cells = std::set<std::pair<std::size_t, std::size_t>>;  ///< row and column of a table, the head is row 0

/// Marks the end of a page's head: its title and the program that made it.
inline constexpr const char* kHeadEnds = "<!-- head ends -->";

/// A self-contained page: one HTML file with inline SVG figures, without scripts or external files. It names the
/// version of the program that made it.
class Page {
 public:
  explicit Page(std::string title);

  void heading(const std::string& words);
  void paragraph(const std::string& words);
  /// A coloured box for the main sentence. kind: "good", "warn" or "bad".
  void verdict(const std::string& words, const std::string& kind);
  /// The first row is the head. Cells that look like numbers are right-aligned.
  /// @param missed cells that miss their goal: marked by colour and by a sign.
  void table(const std::vector<std::vector<std::string>>& rows, const Cells& missed = {});
  void list(const std::vector<std::string>& items);
  /// An SVG as svg() makes it, with a caption.
  void figure(const std::string& svg, const std::string& caption);
  /// Appends HTML unchanged, e.g. another page's body().
  void raw(const std::string& html) { body_ += html; }

  const std::string& body() const { return body_; }
  std::string html() const;
  /// Creates the folder if needed. Errors: InputError naming the file.
  void write(const std::string& path) const;

 private:
  std::string title_;
  std::string body_;
};

}  // namespace m100::lab::plot
