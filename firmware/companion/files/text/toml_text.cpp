// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/text/toml_text.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>

namespace m100::companion {
namespace {

bool is_ascii(char c) { return (static_cast<unsigned char>(c) & 0x80u) == 0; }

/// Copies a text from beginning to end and counts the lines.
class AsciiCopy {
 public:
  explicit AsciiCopy(std::string_view text) : rest_(text) {
    if (rest_.starts_with("\xEF\xBB\xBF")) {
      rest_.remove_prefix(3);  // a byte order mark
    }
    result_.reserve(text.size());
  }

  bool done() const { return rest_.empty(); }
  char next() const { return rest_.front(); }
  bool follows(std::string_view text) const { return rest_.starts_with(text); }
  std::string_view rest() const { return rest_; }
  std::string take_result() { return std::move(result_); }

  void keep(std::size_t bytes = 1) {
    bytes = std::min(bytes, rest_.size());
    line_ += std::count(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(bytes), '\n');
    result_ += rest_.substr(0, bytes);
    rest_.remove_prefix(bytes);
  }

  void replace(std::string_view by) {
    result_ += by;
    rest_.remove_prefix(1);
  }

  [[noreturn]] void refuse(const std::string& what) const { throw TomlTextError(line_, what); }

  /// Copies one character of two to four bytes as TOML's escape.
  void escape() {
    const std::uint32_t lead = static_cast<unsigned char>(next());
    const std::size_t bytes = lead >= 0xF0u ? 4 : lead >= 0xE0u ? 3 : 2;
    std::uint32_t code = lead & (0x7Fu >> bytes);
    bool whole = lead >= 0xC2u && lead <= 0xF4u && rest_.size() >= bytes;
    for (std::size_t i = 1; whole && i < bytes; ++i) {
      const std::uint32_t byte = static_cast<unsigned char>(rest_[i]);
      whole = (byte & 0xC0u) == 0x80u;
      code = code << 6u | (byte & 0x3Fu);
    }
    const bool shortest = code >= (bytes == 4 ? 0x10000u : bytes == 3 ? 0x800u : 0x80u);
    const bool character = code <= 0x10FFFFu && (code < 0xD800u || code > 0xDFFFu);
    if (!whole || !shortest || !character) {
      refuse("a byte is not UTF-8: save the file as UTF-8");
    }
    char text[11];
    std::snprintf(text, sizeof text, "\\U%08X", static_cast<unsigned>(code));
    result_ += text;
    rest_.remove_prefix(bytes);
  }

 private:
  std::string_view rest_;
  std::string result_;
  long line_ = 1;
};

void copy_comment(AsciiCopy& copy) {
  while (!copy.done() && copy.next() != '\n') {
    if (is_ascii(copy.next())) {
      copy.keep();
    } else {
      copy.replace("?");
    }
  }
}

/// Copies a string including its closing quotes. A single-line string also ends with its line; toml++ then refuses it.
void copy_basic_string(AsciiCopy& copy, std::string_view quotes) {
  copy.keep(quotes.size());
  while (!copy.done()) {
    if (copy.follows(quotes)) {
      copy.keep(quotes.size());
      return;
    }
    if (quotes.size() == 1 && copy.next() == '\n') {
      return;
    }
    if (is_ascii(copy.next())) {
      copy.keep(copy.next() == '\\' ? 2 : 1);
    } else {
      copy.escape();
    }
  }
}

void copy_literal_string_as_it_is(AsciiCopy& copy) {
  copy.keep();
  while (!copy.done() && copy.next() != '\n' && copy.next() != '\'') {
    if (!is_ascii(copy.next())) {
      copy.refuse("a string is not closed on its line");
    }
    copy.keep();
  }
  copy.keep(!copy.done() && copy.next() == '\'' ? 1 : 0);
}

/// Copies a literal string; one that needs an escape becomes a basic string.
void copy_literal_string(AsciiCopy& copy) {
  const std::string_view inside = copy.rest().substr(1, copy.rest().find_first_of("'\n", 1) - 1);
  const bool closed = inside.size() + 1 < copy.rest().size() && copy.rest()[inside.size() + 1] == '\'';
  if (std::all_of(inside.begin(), inside.end(), is_ascii) || !closed) {
    copy_literal_string_as_it_is(copy);
    return;
  }
  copy.replace("\"");
  while (copy.next() != '\'') {
    if (!is_ascii(copy.next())) {
      copy.escape();
    } else if (copy.next() == '\\' || copy.next() == '"') {
      copy.replace(copy.next() == '"' ? "\\\"" : "\\\\");
    } else {
      copy.keep();
    }
  }
  copy.replace("\"");
}

void copy_long_literal_string(AsciiCopy& copy) {
  copy.keep(3);
  while (!copy.done() && !copy.follows("'''")) {
    if (!is_ascii(copy.next())) {
      copy.refuse(
          "a character that is not ASCII stands in a literal string of several lines: write it in double quotes");
    }
    copy.keep();
  }
  copy.keep(3);
}

/// Refuses a name of too many parts. Ours have at most three, and toml++ recurses over the parts: a million of them
/// overflowed the stack.
class NameParts {
 public:
  void see(AsciiCopy& copy) {
    constexpr int kMaxDepth = 16;
    const char letter = copy.next();
    if (letter == '.' && ++dots_ > kMaxDepth) {
      copy.refuse("a name has too many parts");
    }
    if (std::string_view("=,[]{}\n").find(letter) != std::string_view::npos) {
      dots_ = 0;
    }
  }

 private:
  int dots_ = 0;
};

/// The end of the message about a text whose first line is neither a section nor a key: what it may be instead.
std::string other_kind(std::string_view text) {
  std::size_t at = 0;
  while (at < text.size() && (text[at] == '#' || text[at] == '\n' || text[at] == '\r')) {
    at = std::min(text.find('\n', at), text.size() - 1) + 1;
  }
  const std::string_view line = text.substr(at, text.find('\n', at) - at);
  const bool is_toml = line.empty() || line.front() == '[' || line.find('=') != std::string_view::npos;
  return is_toml                                    ? ""
         : line.find(',') != std::string_view::npos ? "; this looks like a table (CSV), not TOML"
                                                    : "; this looks like a course or a script, not TOML";
}

}  // namespace

std::string ascii_toml(std::string_view text) {
  AsciiCopy copy(text);
  NameParts parts;
  while (!copy.done()) {
    if (copy.next() == '#') {
      copy_comment(copy);
    } else if (copy.follows("\"\"\"")) {
      copy_basic_string(copy, "\"\"\"");
    } else if (copy.next() == '"') {
      copy_basic_string(copy, "\"");
    } else if (copy.follows("'''")) {
      copy_long_literal_string(copy);
    } else if (copy.next() == '\'') {
      copy_literal_string(copy);
    } else if (is_ascii(copy.next())) {
      parts.see(copy);
      copy.keep();
    } else {
      copy.refuse("a character that is not ASCII stands outside quotes: put the name or the value in double quotes");
    }
  }
  return copy.take_result();
}

toml::table parse_toml(std::string_view text) {
  constexpr std::size_t kLooked = 4096;
  if (text.substr(0, kLooked).find('\0') != std::string_view::npos) {
    throw TomlTextError(1, "is no text: a log or another binary file");
  }
  try {
    return toml::parse(ascii_toml(text));
  } catch (const toml::parse_error& wrong) {
    throw TomlTextError(static_cast<long>(wrong.source().begin.line),
                        std::string(wrong.description()) + other_kind(text));
  }
}

}  // namespace m100::companion
