// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>

namespace m100::companion {

/// Whether three bytes of UTF-8 control how text is displayed: U+2028 and U+2029 end a line; U+202A to U+202E and
/// U+2066 to U+2069 change the direction of the text that follows, so that a line reads as something else.
inline bool is_bidi_control(std::string_view three) {
  const auto last = static_cast<unsigned char>(three[2]);
  return (three.starts_with("\xE2\x80") && last >= 0xA8 && last <= 0xAE) ||
         (three.starts_with("\xE2\x81") && last >= 0xA6 && last <= 0xA9);
}

/// Length of the valid UTF-8 sequence of at least two bytes that `text` begins with; 0: there is none. C1 control
/// characters (U+0080 to U+009F), those of is_bidi_control(), and what RFC 3629 forbids (overlong sequences,
/// surrogates, code points beyond U+10FFFF) are not valid here.
inline std::size_t utf8_sequence(std::string_view text) {
  struct Row {  // RFC 3629: what a sequence begins with, how long it is, what its second byte may be
    unsigned first, last;
    std::size_t length;
    unsigned second_least, second_most;
  };
  constexpr std::array kRows{
      Row{0xC2, 0xC2, 2, 0xA0, 0xBF}, Row{0xC3, 0xDF, 2, 0x80, 0xBF}, Row{0xE0, 0xE0, 3, 0xA0, 0xBF},
      Row{0xE1, 0xEC, 3, 0x80, 0xBF}, Row{0xED, 0xED, 3, 0x80, 0x9F}, Row{0xEE, 0xEF, 3, 0x80, 0xBF},
      Row{0xF0, 0xF0, 4, 0x90, 0xBF}, Row{0xF1, 0xF3, 4, 0x80, 0xBF}, Row{0xF4, 0xF4, 4, 0x80, 0x8F}};
  const auto byte = [&](std::size_t k) { return static_cast<unsigned>(static_cast<unsigned char>(text[k])); };
  const unsigned first = byte(0);
  const auto* const row =
      std::find_if(kRows.begin(), kRows.end(), [&](const Row& one) { return one.first <= first && first <= one.last; });
  if (row == kRows.end() || text.size() < row->length || byte(1) < row->second_least || byte(1) > row->second_most) {
    return 0;
  }
  for (std::size_t k = 2; k < row->length; ++k) {
    if ((byte(k) & 0xC0U) != 0x80U) {
      return 0;
    }
  }
  return row->length == 3 && is_bidi_control(text.substr(0, 3)) ? 0 : row->length;
}

/// Makes text from a file or a command line safe for a terminal: control characters (also those of is_bidi_control())
/// and bytes that are not UTF-8 become \xNN, and text longer than `max_bytes` bytes ends in "...".
inline std::string printable(std::string_view text, std::size_t max_bytes = 1200) {
  std::string out;
  for (std::size_t k = 0; k < text.size();) {
    if (out.size() >= max_bytes) {
      return out + "...";
    }
    const auto byte = static_cast<unsigned char>(text[k]);
    const std::size_t sequence = byte >= 0x80 ? utf8_sequence(text.substr(k)) : 0;
    if (sequence > 0) {
      out += text.substr(k, sequence);
      k += sequence;
    } else if (byte < 0x20 || byte >= 0x7F) {
      std::array<char, 8> escaped{};
      std::snprintf(escaped.data(), escaped.size(), "\\x%02x", static_cast<unsigned>(byte));
      out += escaped.data();
      ++k;
    } else {
      out += text[k++];
    }
  }
  return out;
}

}  // namespace m100::companion
