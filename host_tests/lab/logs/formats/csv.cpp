// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/formats/csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/logs/no_such_column.h"
#include "host_tests/lab/printable.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab::logs {
namespace {

constexpr std::string_view kEmpty = "'' is not a finite number";

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) {
    return {};
  }
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

/// Splits a record at the separators. Quotes may enclose separators, a doubled quote means one quote, line feeds inside
/// quotes are not allowed. nullopt: a quote is left open.
std::optional<std::vector<std::string>> cells_of(std::string_view line, char separator) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') {
      cells.back() += c;
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == separator && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  if (quoted) {
    return std::nullopt;
  }
  for (std::string& cell : cells) {
    cell = std::string(trimmed(cell));
  }
  return cells;
}

char separator_of(std::string_view header) {
  char best = ',';
  std::ptrdiff_t most = 0;
  for (const char candidate : {',', ';', '\t'}) {
    const auto count = std::count(header.begin(), header.end(), candidate);
    if (count > most) {
      most = count;
      best = candidate;
    }
  }
  return best;
}

class CsvLog final : public RawLog {
 public:
  explicit CsvLog(const std::string& file) : RawLog(file), text_(whole_file(file)) { split_rows(); }

  std::vector<std::string> names() const override { return names_; }

  long line_of(std::size_t sample) const override { return rows_.at(sample).line; }

  RawColumn column(const std::string& name, const std::string& map_key) const override {
    const auto found = std::find(names_.begin(), names_.end(), name);
    if (found == names_.end()) {
      throw NoSuchColumn(file(), header_line_, name,
                         "no such column (wanted for " + map_key + "); there are: " + nearest_names(names_, name));
    }
    const auto index = static_cast<std::size_t>(found - names_.begin());
    RawColumn column;
    column.values.reserve(rows_.size());
    std::string first_wrong;
    long wrong_line = 0;
    std::size_t wrong = 0;
    std::size_t numbers = 0;
    for (const Row& row : rows_) {
      std::string error_text;
      column.values.push_back(value(row, index, error_text));
      if (error_text.empty()) {
        ++numbers;
        continue;
      }
      if (first_wrong.empty()) {
        first_wrong = error_text;
        wrong_line = row.line;
      }
      wrong += error_text == kEmpty ? 0U : 1U;  // empty cells mean that nothing was sampled, however many there are
    }
    if (numbers == 0 || 2 * wrong >= rows_.size()) {
      throw InputError(file(), wrong_line, name, first_wrong);
    }
    return column;
  }

  std::string format() const override { return "CSV"; }

  /// The file as one stream; its clock is the column with the first of these names that the file has.
  std::vector<TopicSummary> topics() const override {
    std::vector<double> clock(rows_.size(), std::numeric_limits<double>::quiet_NaN());
    for (const char* const name : {"t_s", "time_s", "time", "t", "timestamp", "Time"}) {
      if (const auto found = std::find(names_.begin(), names_.end(), name); found != names_.end()) {
        for (std::size_t k = 0; k < rows_.size(); ++k) {
          std::string ignored;
          clock[k] = value(rows_[k], static_cast<std::size_t>(found - names_.begin()), ignored);
        }
        break;
      }
    }
    return {
        summary_of("", "", clock,
                   {names_.begin(), names_.begin() + static_cast<std::ptrdiff_t>(std::min(names_.size(), kMaxNames))})};
  }

 private:
  struct Row {
    std::string_view text;
    long line;
  };

  void split_rows() {
    std::string_view rest = text_;
    if (rest.rfind("\xEF\xBB\xBF", 0) == 0) {
      rest.remove_prefix(3);
    }
    for (long line = 1; !rest.empty(); ++line) {
      const std::size_t end = rest.find('\n');
      const std::string_view text = trimmed_end(rest.substr(0, end));
      rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
      if (trimmed(text).empty()) {
        continue;
      }
      names_.empty() ? read_header(text, line) : rows_.push_back({text, line});
    }
    if (names_.empty()) {
      throw InputError(file(), 0, "", "is empty");
    }
    const bool cut = text_.back() != '\n' && !rows_.empty();
    if (cut && rows_.size() > 1 && cell_count(rows_.back()) != names_.size()) {
      rows_.pop_back();  // incomplete last row: the logger was stopped
    }
    if (rows_.empty()) {
      throw InputError(file(), header_line_, "", "has a header but no samples");
    }
  }

  static std::string_view trimmed_end(std::string_view text) {
    return !text.empty() && text.back() == '\r' ? text.substr(0, text.size() - 1) : text;
  }

  void read_header(std::string_view text, long line) {
    header_line_ = line;
    separator_ = separator_of(text);
    const auto cells = cells_of(text, separator_);
    if (!cells) {
      throw InputError(file(), line, "", "a quote is left open in the header");
    }
    names_ = *cells;
    for (std::size_t i = 0; i < names_.size(); ++i) {  // a table's index is often written without a name
      names_[i] = names_[i].empty() ? "column_" + std::to_string(i + 1) : std::move(names_[i]);
    }
    std::vector<std::string_view> sorted(names_.begin(), names_.end());
    std::sort(sorted.begin(), sorted.end());
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    if (twice != sorted.end()) {
      throw InputError(file(), line, std::string(*twice), "the column appears twice");
    }
  }

  std::size_t cell_count(const Row& row) const {
    if (row.text.find('"') != std::string_view::npos) {
      const auto cells = cells_of(row.text, separator_);
      return cells ? cells->size() : 0;
    }
    return static_cast<std::size_t>(std::count(row.text.begin(), row.text.end(), separator_)) + 1;
  }

  /// The cell as text; none if `error_text` is set. Rows without quotes, nearly all of them, are split without copying.
  std::string cell(const Row& row, std::size_t index, std::string& error_text) const {
    const std::size_t count = cell_count(row);
    if (count != names_.size()) {
      error_text = count == 0
                       ? "a quote is left open"
                       : "the row has " + std::to_string(count) + " cells, the header " + std::to_string(names_.size());
      return {};
    }
    if (row.text.find('"') != std::string_view::npos) {
      return (*cells_of(row.text, separator_))[index];
    }
    std::size_t begin = 0;
    for (std::size_t i = 0; i < index; ++i) {
      begin = row.text.find(separator_, begin) + 1;
    }
    const std::size_t end = row.text.find(separator_, begin);
    return std::string(trimmed(row.text.substr(begin, end == std::string_view::npos ? end : end - begin)));
  }

  /// The cell as a number; NaN with `error_text` if it is not one.
  double value(const Row& row, std::size_t index, std::string& error_text) const {
    const std::string text = cell(row, index, error_text);
    const char* begin = text.c_str() + (text.rfind('+', 0) == 0 ? 1 : 0);
    const char* end = text.c_str() + text.size();
    double result = 0;
    const auto [stop, error] = std::from_chars(begin, end, result);
    if (error_text.empty() && error == std::errc{} && stop == end && std::isfinite(result)) {
      return result;
    }
    if (error_text.empty()) {
      error_text = "'" + printable(text, 60) + "' is not a finite number";
    }
    return std::numeric_limits<double>::quiet_NaN();
  }

  std::string text_;
  std::vector<std::string> names_;
  std::vector<Row> rows_;
  long header_line_ = 1;
  char separator_ = ',';
};

}  // namespace

std::unique_ptr<RawLog> open_csv(const std::string& file) { return std::make_unique<CsvLog>(file); }

}  // namespace m100::lab::logs
