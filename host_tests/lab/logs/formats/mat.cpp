// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/formats/mat.h"

#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <string_view>

#include "host_tests/lab/logs/formats/mat_file.h"
#include "host_tests/lab/logs/no_such_column.h"

namespace m100::lab::logs {
namespace {

/// A path split at its dots, and the row index after the last name (1-based; 0: none).
struct Path {
  std::vector<std::string> parts;
  std::size_t row = 0;
};

/// Whether these are whole numbers that mostly increase by one.
bool counts(const std::vector<double>& numbers) {
  std::size_t ones = 0;
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    if (numbers[k] != std::round(numbers[k])) {
      return false;
    }
    ones += k > 0 && numbers[k] - numbers[k - 1] == 1.0 ? 1U : 0U;
  }
  return numbers.size() > 2 && 2 * ones > numbers.size();
}

/// Visits every real matrix with its path.
template <typename Visit>
void walk(const MatVariable& variable, const std::string& path, Visit&& visit) {
  if (variable.is_matrix) {
    visit(path, variable);
  }
  for (const MatVariable& field : variable.fields) {
    walk(field, path + "." + field.name, visit);
  }
}

class MatLog final : public RawLog {
 public:
  explicit MatLog(const std::string& file) : RawLog(file), content_(file) {}

  std::string format() const override { return content_.version(); }

  std::vector<std::string> names() const override {
    std::vector<std::string> all;
    each([&](const std::string& path, const MatVariable& matrix) {
      for (std::size_t row = 1; row <= matrix.width() && all.size() < kMaxNames; ++row) {
        all.push_back(matrix.width() == 1 ? path : path + "[" + std::to_string(row) + "]");
      }
    });
    return all;
  }

  RawColumn column(const std::string& name, const std::string& map_key) const override {
    constexpr std::string_view kEnding = ".mat:";
    if (const std::size_t colon = name.find(kEnding); colon != std::string::npos) {
      return beside(name.substr(0, colon + kEnding.size() - 1)).column(name.substr(colon + kEnding.size()), map_key);
    }
    const Path path = parse(name);
    const MatVariable* parent = nullptr;
    const MatVariable* const variable = find(path.parts, parent);
    if (variable == nullptr || !variable->is_matrix) {
      throw NoSuchColumn(file(), 0, name,
                         (variable == nullptr ? "no such variable" : "is not a real matrix") +
                             std::string(" (wanted for ") + map_key + "); there are: " + nearest_names(names(), name));
    }
    const std::size_t width = variable->width();
    if ((path.row == 0 && width != 1) || path.row > width) {
      throw NoSuchColumn(file(), 0, name,
                         "has " + std::to_string(width) + " rows; write [1] to [" + std::to_string(width) + "]");
    }
    RawColumn column{.values = variable->row(path.row == 0 ? 0 : path.row - 1), .time_s = {}, .sequence = {}};
    require_mostly_sound(column.values, name);
    column.sequence = counter_beside(parent);
    return column;
  }

  /// One topic for each group of matrices of the same length.
  std::vector<TopicSummary> topics() const override {
    std::map<std::size_t, TopicSummary> by_length;
    std::map<std::size_t, std::vector<double>> clocks;
    each([&](const std::string& path, const MatVariable& matrix) {
      const std::size_t width = matrix.width();
      by_length[matrix.length()].fields.push_back(path + (width == 1 ? "" : "[1.." + std::to_string(width) + "]"));
      if (width == 1 && (path.ends_with(".t") || path == "t" || path.ends_with("time"))) {
        clocks.emplace(matrix.length(), matrix.row(0));
      }
    });
    std::vector<TopicSummary> all;
    for (auto& [length, topic] : by_length) {
      const auto clock = clocks.find(length);
      all.push_back(
          summary_of("", "", clock == clocks.end() ? std::vector<double>{} : clock->second, std::move(topic.fields)));
      all.back().messages = length;
    }
    return all;
  }

 private:
  template <typename Visit>
  void each(Visit&& visit) const {
    for (const MatVariable& variable : content_.variables()) {
      walk(variable, variable.name, visit);
    }
  }

  /// Another MAT-file in the same folder, opened when it is first used.
  const MatLog& beside(const std::string& name) const {
    std::unique_ptr<MatLog>& other = beside_[name];
    if (other == nullptr) {
      const std::filesystem::path path = std::filesystem::path(file()).parent_path() / name;
      if (!std::filesystem::is_regular_file(path)) {
        throw NoSuchColumn(file(), 0, name, "is not a file in the same folder");
      }
      other = std::make_unique<MatLog>(path.string());
    }
    return *other;
  }

  Path parse(const std::string& name) const {
    Path path;
    std::string rest = name;
    if (!rest.empty() && rest.back() == ']') {
      const std::size_t open = std::min(rest.find('['), rest.size() - 1);
      const char* begin = rest.data() + open + 1;
      const char* end = rest.data() + rest.size() - 1;
      if (begin >= end || std::from_chars(begin, end, path.row).ptr != end || path.row == 0) {
        throw NoSuchColumn(file(), 0, name, "the row in brackets must be a number from 1");
      }
      rest.resize(open);
    }
    for (std::size_t begin = 0; begin <= rest.size();) {
      const std::size_t dot = std::min(rest.find('.', begin), rest.size());
      path.parts.push_back(rest.substr(begin, dot - begin));
      begin = dot + 1;
    }
    return path;
  }

  const MatVariable* find(const std::vector<std::string>& parts, const MatVariable*& parent) const {
    const MatVariable* at = nullptr;
    for (const MatVariable& variable : content_.variables()) {
      at = parts.front() == variable.name ? &variable : at;
    }
    for (std::size_t i = 1; i < parts.size() && at != nullptr; ++i) {
      parent = at;
      at = at->field(parts[i]);
    }
    return at;
  }

  /// The message counter of a column: a field of the same struct with one of a few known names.
  static std::vector<double> counter_beside(const MatVariable* structure) {
    for (const char* name : {"i", "seq", "sequence"}) {
      const MatVariable* const counter = structure == nullptr ? nullptr : structure->field(name);
      if (counter == nullptr || !counter->is_matrix || counter->width() != 1) {
        continue;
      }
      std::vector<double> numbers = counter->row(0);
      if (counts(numbers)) {
        return numbers;
      }
    }
    return {};
  }

  MatFile content_;
  mutable std::map<std::string, std::unique_ptr<MatLog>> beside_;  ///< opened when a column of theirs is read
};

}  // namespace

std::unique_ptr<RawLog> open_mat(const std::string& file) { return std::make_unique<MatLog>(file); }

}  // namespace m100::lab::logs
