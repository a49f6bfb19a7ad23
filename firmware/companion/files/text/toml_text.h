// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/companion/files/text/file_error.h"
#include "firmware/companion/files/text/suggestion.h"

namespace m100::companion {

/// A value of a TOML file, which knows where it stands. Errors of all functions: FileError with file, line and key.
class TomlNode {
 public:
  enum class Kind : std::uint8_t { kTable, kArray, kText, kNumber, kFlag, kOther };

  bool is(Kind kind) const { return kind_ == kind; }
  bool is_table() const { return is(Kind::kTable); }
  bool is_array() const { return is(Kind::kArray); }
  long line() const { return line_; }
  /// Its key in its table, and with the keys of the tables around it: "damping_ratio", "axis.roll.damping_ratio".
  const std::string& key() const { return key_; }
  const std::string& name() const { return name_; }
  /// What a table holds, in the order of the keys, or an array.
  const std::vector<TomlNode>& entries() const { return entries_; }
  /// A table's entry; null: it has none with that key, or this is no table.
  const TomlNode* get(std::string_view key) const;

  [[noreturn]] void refuse(const std::string& what) const { refuse(name_, what); }
  [[noreturn]] void refuse(const std::string& name, const std::string& what) const {
    throw FileError(*file_, line_, name, what);
  }
  /// Refuses an entry that this table lacks.
  [[noreturn]] void refuse_without(std::string_view key, const std::string& what) const {
    refuse(name_ + (name_.empty() ? "" : ".") + std::string(key), what);
  }

  const TomlNode& table() const;
  double number() const;
  double number(double low, double high) const;
  bool flag() const;
  /// Empty: it is no text.
  const std::string& text() const { return text_; }

  /// The row of its key. @param rows those of its table, of which `key` gives the keys. @param what it is
  template <typename Rows, typename Key>
  const auto& row_of(const Rows& rows, Key key, const std::string& what = "unknown key") const {
    const auto row =
        std::find_if(rows.begin(), rows.end(), [&](const auto& one) { return std::invoke(key, one) == key_; });
    if (row == rows.end()) {
      refuse(what + did_you_mean(key_, rows, key));
    }
    return *row;
  }
  /// The row of the word that it is. @param rows have a `word`.
  template <typename Rows>
  const auto& word_of(const Rows& rows) const {
    std::string known;
    for (const auto& row : rows) {
      if (row.word == text_) {
        return row;
      }
      known += (known.empty() ? "\"" : " or \"") + std::string(row.word) + "\"";
    }
    refuse("must be " + known + did_you_mean(text_, rows, [](const auto& row) { return row.word; }));
  }

 private:
  friend struct TomlBuilder;

  Kind kind_ = Kind::kTable;
  long line_ = 0;
  std::shared_ptr<const std::string> file_;
  std::string key_, name_;
  std::string text_;
  double number_ = 0.0;
  bool flag_ = false;
  std::vector<TomlNode> entries_;
};

/// A number as messages show it: "2.5".
std::string text_of(double value);

/// The line `key = "text"`, with the quotes and escapes that the text needs.
std::string toml_line(std::string_view key, const std::string& text);

/// Parses a text of TOML 1.0. @param file its name in messages. Letters of every language may stand in comments and in
/// quotes. Errors: FileError, also for a name of more than kMaxTomlDepth parts and for tables nested as deep.
TomlNode parse_toml(std::string_view text, const std::string& file);
inline constexpr int kMaxTomlDepth = 16;

}  // namespace m100::companion
