// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/text/toml_text.h"

#include <sstream>

// toml++ 3.3 has assertions that end a debug build on some invalid texts ("[", then a new line); the code after them
// refuses such texts as well. Only this file may include toml++.
#define TOML_ASSERT(condition) static_cast<void>(0)
#define TOML_MAX_NESTED_VALUES 16
#include <toml++/toml.h>

namespace m100::companion {

/// Copies what the library has parsed.
struct TomlBuilder {
  std::shared_ptr<const std::string> file;

  // Recurses at most kMaxTomlDepth times.
  TomlNode node(const toml::node& from, const std::string& key, const std::string& name, int depth) const {
    TomlNode out;
    out.file_ = file;
    out.key_ = key;
    out.name_ = name;
    out.line_ = depth == 0 ? 0 : static_cast<long>(from.source().begin.line);
    if (depth > kMaxTomlDepth) {
      out.refuse("", "a name has too many parts");
    }
    if (const toml::table* const table = from.as_table(); table != nullptr) {
      for (const auto& [word, value] : *table) {
        const std::string inside(word.str());
        out.entries_.push_back(node(value, inside, name.empty() ? inside : name + "." + inside, depth + 1));
      }
    } else if (const toml::array* const array = from.as_array(); array != nullptr) {
      out.kind_ = TomlNode::Kind::kArray;
      for (const toml::node& value : *array) {
        out.entries_.push_back(node(value, "", name, depth + 1));
      }
    } else {
      fill(from, out);
    }
    return out;
  }

  static void fill(const toml::node& from, TomlNode& out) {
    using Kind = TomlNode::Kind;
    out.kind_ = from.is_string()    ? Kind::kText
                : from.is_number()  ? Kind::kNumber
                : from.is_boolean() ? Kind::kFlag
                                    : Kind::kOther;
    out.text_ = from.is_string() ? from.as_string()->get() : "";
    out.number_ = from.is_integer()          ? static_cast<double>(from.as_integer()->get())
                  : from.is_floating_point() ? from.as_floating_point()->get()
                                             : 0.0;
    out.flag_ = from.is_boolean() && from.as_boolean()->get();
  }
};

namespace {

bool is_ascii(char c) { return (static_cast<unsigned char>(c) & 0x80U) == 0; }

/// The text with a question mark and two letters in place of every byte that is not ASCII. They are TOML in comments
/// and in quotes, and the question mark is none elsewhere. The library has undefined behaviour on other letters outside
/// quotes, so it sees this text first.
std::string ascii_of(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (is_ascii(c)) {
      out += c;
    } else {
      const auto byte = static_cast<unsigned char>(c);
      out += {'?', static_cast<char>('a' + byte / 16), static_cast<char>('a' + byte % 16)};
    }
  }
  return out;
}

/// The first line with a name of so many parts that the library would overflow the stack, which it does with a million;
/// 0: there is none. Full stops in quotes and comments count too: a line of them is no line of ours.
long line_of_long_name(std::string_view text) {
  constexpr int kMaxStops = 256;
  long line = 1;
  int stops = 0;
  for (const char c : text) {
    stops = c == '.' ? stops + 1 : std::string_view("=,[]{}\n").find(c) != std::string_view::npos ? 0 : stops;
    if (stops > kMaxStops) {
      return line;
    }
    line += c == '\n' ? 1 : 0;
  }
  return 0;
}

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

toml::table parsed(std::string_view text) {
  if (!std::all_of(text.begin(), text.end(), is_ascii)) {
    static_cast<void>(toml::parse(ascii_of(text)));
  }
  return toml::parse(text);
}

std::string why_refused(const toml::parse_error& wrong, std::string_view text) {
  std::string_view line = text;
  for (auto number = wrong.source().begin.line; number > 1 && line.find('\n') != std::string_view::npos; --number) {
    line.remove_prefix(line.find('\n') + 1);
  }
  line = line.substr(0, line.find('\n'));
  const bool is_ascii_line = std::all_of(line.begin(), line.end(), is_ascii);
  return std::string(wrong.description()) +
         (is_ascii_line ? other_kind(text)
                        : "; a name or a text with a character that is not ASCII needs double quotes");
}

}  // namespace

const TomlNode* TomlNode::get(std::string_view key) const {
  const auto found =
      std::find_if(entries_.begin(), entries_.end(), [key](const TomlNode& one) { return one.key_ == key; });
  return found == entries_.end() || !is_table() ? nullptr : &*found;
}

const TomlNode& TomlNode::table() const {
  if (!is_table()) {
    refuse("must be a table");
  }
  return *this;
}

double TomlNode::number() const {
  if (!is(Kind::kNumber)) {
    refuse("must be a number");
  }
  return number_;
}

double TomlNode::number(double low, double high) const {
  if (!(number() >= low && number_ <= high)) {
    refuse(text_of(number_) + " is outside [" + text_of(low) + ", " + text_of(high) + "]");
  }
  return number_;
}

bool TomlNode::flag() const {
  if (!is(Kind::kFlag)) {
    refuse("must be true or false");
  }
  return flag_;
}

std::string text_of(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

std::string toml_line(std::string_view key, const std::string& text) {
  std::ostringstream out;
  toml::table quoted;
  quoted.insert(key, text);
  out << quoted << "\n";
  return out.str();
}

TomlNode parse_toml(std::string_view text, const std::string& file) {
  constexpr std::size_t kLooked = 4096;
  if (text.substr(0, kLooked).find('\0') != std::string_view::npos) {
    throw FileError(file, 1, "", "is no text: a log or another binary file");
  }
  if (text.starts_with("\xEF\xBB\xBF")) {
    text.remove_prefix(3);  // a byte order mark
  }
  if (const long line = line_of_long_name(text); line > 0) {
    throw FileError(file, line, "", "a name has too many parts");
  }
  try {
    const TomlBuilder builder{std::make_shared<const std::string>(file)};
    return builder.node(parsed(text), "", "", 0);
  } catch (const toml::parse_error& wrong) {
    throw FileError(file, static_cast<long>(wrong.source().begin.line), "", why_refused(wrong, text));
  }
}

}  // namespace m100::companion
