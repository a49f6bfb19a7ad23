// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdarg>
#include <cstdio>
#include <string>

namespace m100::lab {

/// What std::printf would print, up to 399 characters: a sentence of a report.
[[gnu::format(printf, 1, 2)]] inline std::string printed(const char* format, ...) {
  std::array<char, 400> text{};
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text.data(), text.size(), format, arguments);
  va_end(arguments);
  return text.data();
}

}  // namespace m100::lab
