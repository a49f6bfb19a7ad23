// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>

namespace m100::companion {

/// Length of the valid UTF-8 sequence of at least two bytes that `text` begins with; 0: there is none. Control
/// characters of the second kind (U+0080 to U+009F) count as none, and so does what RFC 3629 forbids: a character that
/// is written longer than it need be (a control character might hide so), half of a pair, and what is past U+10FFFF.
inline std::size_t utf8_sequence(std::string_view text) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned>(static_cast<unsigned char>(text[k])); };
  const unsigned first = byte(0);
  const std::size_t length = first >= 0xC2 && first < 0xE0   ? 2
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xF0 && first < 0xF5 ? 4
                                                             : 0;
  if (length == 0 || text.size() < length) {
    return 0;
  }
  const unsigned least = first == 0xC2 || first == 0xE0 ? 0xA0U : first == 0xF0 ? 0x90U : 0x80U;
  const unsigned most = first == 0xED ? 0x9FU : first == 0xF4 ? 0x8FU : 0xBFU;
  if (byte(1) < least || byte(1) > most) {
    return 0;
  }
  for (std::size_t k = 1; k < length; ++k) {
    if ((byte(k) & 0xC0U) != 0x80U) {
      return 0;
    }
  }
  return length;
}

/// Text that came from a file or a command line, fit for a terminal: control characters and bytes that are no UTF-8
/// become \xNN, and what is longer than `most` bytes ends in "...".
inline std::string printable(std::string_view text, std::size_t most = 1200) {
  std::string out;
  for (std::size_t k = 0; k < text.size();) {
    if (out.size() >= most) {
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
