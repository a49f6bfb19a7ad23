// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <string_view>

namespace m100::companion {

/// Whether the text is a decimal number, finite and inside the type's range.
/// strtod and strtoull accept more, and then give another number than was meant: 010 is 8, 0x10 is 16, a seed of 20
/// nines becomes the largest integer, and nan passes a check that refuses values below or above a range.
inline bool is_plain_number(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::general);
  return error == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
}

/// Whether the text is a decimal whole number of at most 64 bits, with or without a minus, without leading zeros.
inline bool is_plain_whole_number(std::string_view text) {
  const std::string_view digits = text.substr(text.starts_with('-') ? 1 : 0);
  if (digits.empty() || (digits.size() > 1 && digits.front() == '0')) {
    return false;
  }
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  return error == std::errc{} && end == digits.data() + digits.size();
}

}  // namespace m100::companion
