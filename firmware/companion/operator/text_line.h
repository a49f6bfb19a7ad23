// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string_view>

namespace m100::companion {

/// A line of text without heap, for the thread that flies (promise R1). Text beyond kMaxBytes is cut off.
class TextLine {
 public:
  static constexpr std::size_t kMaxBytes = 640;

  TextLine& add(std::string_view text) {
    const std::size_t fits = std::min(text.size(), space_.size() - used_);
    std::copy_n(text.begin(), fits, space_.begin() + static_cast<std::ptrdiff_t>(used_));
    used_ += fits;
    return *this;
  }
  TextLine& add(const TextLine& other) { return add(other.text()); }
  /// Adds a number in fixed-point notation. @param digits after the point.
  TextLine& add(double value, int digits) {
    std::array<char, 48> number{};
    const int size = std::snprintf(number.data(), number.size(), "%.*f", digits, value);
    return add({number.data(), std::min(number.size() - 1, static_cast<std::size_t>(std::max(size, 0)))});
  }
  /// Adds a number with at least two digits that matter, and at most four after the point.
  TextLine& add_significant(double value) { return add(value, digits_of(value)); }
  static int digits_of(double value) {
    const double size = std::abs(value);
    return size >= 0.95 ? 1 : size >= 0.095 ? 2 : size >= 0.0095 ? 3 : 4;
  }
  std::string_view text() const { return {space_.data(), used_}; }

 private:
  std::array<char, kMaxBytes> space_{};
  std::size_t used_ = 0;
};

}  // namespace m100::companion
