// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace m100::lab::logs {

/// A number inside a ULog message: its offset after the message's number, and how its bytes are read.
struct UlogNumber {
  std::size_t at = 0;
  std::size_t bytes = 0;
  double (*read)(const char*) = nullptr;
};

/// The formats that a ULog defines ('F'), and the offsets of their fields. A format is parsed when it is first used, so
/// that an unused format may be invalid. Arrays and nested formats are expanded by list() only, because a definition of
/// fifty bytes may describe four thousand million numbers.
class UlogFormats {
 public:
  /// Takes the definition of a format. @returns false if it has no name.
  bool define(std::string_view text);

  /// Where a path in a format lies in the message: "q[3]", "place.x", "esc[2].rpm". nullopt: no such number.
  std::optional<UlogNumber> find(const std::string& format, std::string_view path);

  /// Appends prefix + path of the format's numbers to `out`, until `out` has `most` names. Paddings have no name.
  void list(const std::string& format, const std::string& prefix, std::size_t most, std::vector<std::string>& out);
  /// At most `most` names of the format's own fields, one for a whole array ("q[4]"); a nested format ends in a dot.
  std::vector<std::string> fields(const std::string& format, std::size_t most);

 private:
  struct Field {
    std::string name;
    std::string type;
    bool is_array = false;
    std::size_t count = 1;
    std::size_t at = 0;
    std::size_t each = 0;  ///< bytes of one element
    bool named = false;    ///< it can be a column
  };
  struct Format {
    std::string text;
    bool resolved = false;
    bool broken = false;
    std::size_t bytes = 0;
    bool named = false;  ///< it holds a number that is not padding
    std::vector<Field> fields;
  };
  /// Longest payload of a message. A format cannot log anything beyond it.
  static constexpr std::size_t kMaxBytes = 65535;
  static constexpr int kDeepest = 16;

  const Format* resolved(const std::string& name, int depth);
  bool resolve(Format& format, int depth);
  /// Computes the bytes of one element. @returns false: its type is not defined.
  bool measure(Field& field, int depth);

  std::map<std::string, Format, std::less<>> formats_;
};

}  // namespace m100::lab::logs
