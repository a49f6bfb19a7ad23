// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/formats/ardupilot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string_view>

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/logs/formats/read_number.h"
#include "host_tests/lab/whole_file.h"

// ArduPilot's binary log: records {A3 95 type body}, little endian and packed. FMT (type 128) defines the length and
// name of every type and the letters and labels of its fields; in newer logs UNIT, MULT and FMTU define units and
// multipliers. The reader needs to know only the labels of clocks, GPS weeks and instances, so it reads any version.

namespace m100::lab::logs {
namespace {

constexpr std::size_t kHeadBytes = 3;
constexpr unsigned kFmt = 128;
constexpr std::size_t kFmtBytes = 89;

/// How the field letters are read; `read` is null for text, arrays and half precision (`g`).
struct Letter {
  char letter;
  std::size_t bytes;
  double (*read)(const char*);
  double factor;  ///< scale that the letter itself implies; 1: none
};
constexpr std::array<Letter, 21> kLetters{{{'a', 64, nullptr, 1},  // 32 numbers of 16 bits: not a column
                                           {'b', 1, &read_as<std::int8_t>, 1},
                                           {'B', 1, &read_as<std::uint8_t>, 1},
                                           {'M', 1, &read_as<std::uint8_t>, 1},
                                           {'h', 2, &read_as<std::int16_t>, 1},
                                           {'H', 2, &read_as<std::uint16_t>, 1},
                                           {'c', 2, &read_as<std::int16_t>, 0.01},
                                           {'C', 2, &read_as<std::uint16_t>, 0.01},
                                           {'g', 2, nullptr, 1},  // half precision
                                           {'i', 4, &read_as<std::int32_t>, 1},
                                           {'I', 4, &read_as<std::uint32_t>, 1},
                                           {'f', 4, &read_as<float>, 1},
                                           {'n', 4, nullptr, 1},
                                           {'e', 4, &read_as<std::int32_t>, 0.01},
                                           {'E', 4, &read_as<std::uint32_t>, 0.01},
                                           {'L', 4, &read_as<std::int32_t>, 1e-7},
                                           {'d', 8, &read_as<double>, 1},
                                           {'q', 8, &read_as<std::int64_t>, 1},
                                           {'Q', 8, &read_as<std::uint64_t>, 1},
                                           {'N', 16, nullptr, 1},
                                           {'Z', 64, nullptr, 1}}};

/// IEEE 754 half precision.
double read_half(const char* bytes) {
  const auto bits = read_number<std::uint16_t>(bytes);
  const int exponent = (bits >> 10U) & 31;
  const double mantissa = bits & 1023U;
  const double size = exponent == 0    ? std::ldexp(mantissa, -24)
                      : exponent == 31 ? std::numeric_limits<double>::quiet_NaN()
                                       : std::ldexp(mantissa + 1024.0, exponent - 25);
  return (bits & 0x8000U) != 0 ? -size : size;
}

const Letter* letter_of(char letter) {
  const auto found =
      std::find_if(kLetters.begin(), kLetters.end(), [&](const Letter& l) { return l.letter == letter; });
  return found == kLetters.end() ? nullptr : &*found;
}

/// Text of a field of fixed width, up to its first NUL.
std::string text(std::string_view bytes) { return std::string(bytes.substr(0, bytes.find('\0'))); }

struct Field {
  std::string label;
  std::size_t at = 0;  ///< offset after the record's header
  const Letter* letter = nullptr;
  double factor = 1.0;
};

struct Type {
  std::string name;
  std::size_t bytes = 0;  ///< of a record with its header; 0: not defined
  std::vector<Field> fields;
  std::string multipliers;  ///< from FMTU, one letter for each field
  std::string units;
  std::vector<std::size_t> records;  ///< offsets of their bodies
};

class ArduPilotLog final : public RawLog {
 public:
  explicit ArduPilotLog(const std::string& file) : RawLog(file), bytes_(whole_file(file)) {
    types_[kFmt].bytes = kFmtBytes;
    read_records();
    take_units();
    for (std::size_t i = 0; i < types_.size(); ++i) {
      if (!types_[i].records.empty() && !types_[i].name.empty()) {
        by_name_.emplace(types_[i].name, i);
      }
    }
    if (by_name_.empty()) {
      throw InputError(file, 0, "", "contains definitions but no message");
    }
  }

  std::string format() const override { return "ArduPilot"; }
  bool has_times_of_arrival() const override { return false; }

  std::vector<std::string> names() const override {
    std::vector<std::string> all;
    for (const auto& [name, index] : by_name_) {
      for (const unsigned instance : instances(types_[index])) {
        for (const Field& field : types_[index].fields) {
          if (is_number(field) && all.size() < kMaxNames) {
            all.push_back(stream_name(types_[index], instance) + "." + field.label);
          }
        }
      }
    }
    return all;
  }

  RawColumn column(const std::string& name, const std::string& map_key) const override {
    const std::size_t dot = name.find('.');
    const std::size_t colon = name.substr(0, dot).find(':');
    const auto found = by_name_.find(name.substr(0, std::min(dot, colon)));
    if (found == by_name_.end() || dot == std::string::npos) {
      no_such_column(name, map_key);
    }
    const Type& type = types_[found->second];
    const std::string wanted = colon == std::string::npos ? "" : name.substr(colon + 1, dot - colon - 1);
    const auto all = instances(type);
    const auto instance = std::find_if(all.begin(), all.end(),
                                       [&](unsigned one) { return wanted.empty() || wanted == std::to_string(one); });
    const auto field = std::find_if(type.fields.begin(), type.fields.end(),
                                    [&](const Field& one) { return one.label == name.substr(dot + 1); });
    if (instance == all.end() || field == type.fields.end() || !is_number(*field)) {
      no_such_column(name, map_key);
    }
    RawColumn column{.values = values(type, *field, *instance), .time_s = times(type, *instance), .sequence = {}};
    if (column.time_s.empty()) {
      throw InputError(file(), 0, name, "the message has no time of the autopilot's clock (TimeUS or TimeMS)");
    }
    require_mostly_sound(column.values, name);
    return column;
  }

  std::vector<TopicSummary> topics() const override {
    std::vector<TopicSummary> all;
    for (const auto& [name, index] : by_name_) {
      const Type& type = types_[index];
      std::vector<std::string> fields;
      for (std::size_t i = 0; i < type.fields.size(); ++i) {
        const std::string unit = i < type.units.size() ? unit_of(type.units[i]) : "";
        fields.push_back(type.fields[i].label + (unit.empty() ? "" : " (" + unit + ")"));
      }
      for (const unsigned instance : instances(type)) {
        all.push_back(summary_of(stream_name(type, instance), "", times(type, instance), fields));
        all.back().messages = all.back().messages == 0 ? type.records.size() : all.back().messages;
      }
    }
    return all;
  }

  std::vector<std::string> notes() const override {
    return lost_bytes_ == 0 ? std::vector<std::string>{}
                            : std::vector<std::string>{std::to_string(lost_bytes_) +
                                                       " bytes of the file are damaged and were skipped"};
  }

 private:
  static bool is_number(const Field& field) { return field.letter->read != nullptr || field.letter->letter == 'g'; }

  std::string_view record(const Type& type, std::size_t body) const {
    return std::string_view(bytes_).substr(body, type.bytes - kHeadBytes);
  }

  void read_records() {
    const std::string_view all = bytes_;
    for (std::size_t at = 0; at + kHeadBytes <= all.size();) {
      const auto number = static_cast<std::size_t>(static_cast<unsigned char>(all[at + 2]));
      Type& type = types_[number];
      if (all[at] != '\xA3' || all[at + 1] != '\x95' || type.bytes == 0) {
        ++lost_bytes_;
        ++at;
        continue;
      }
      if (at + type.bytes > all.size()) {
        return;  // the log ends within a record
      }
      if (number == kFmt) {
        define(all.substr(at + kHeadBytes, kFmtBytes - kHeadBytes));
      } else {
        type.records.push_back(at + kHeadBytes);
      }
      at += type.bytes;
    }
  }

  /// Takes a definition; ignores it if a letter is unknown or the sizes of all do not add up to its length.
  void define(std::string_view body) {
    const auto number = static_cast<std::size_t>(static_cast<unsigned char>(body[0]));
    Type type;
    type.bytes = static_cast<std::size_t>(static_cast<unsigned char>(body[1]));
    type.name = text(body.substr(2, 4));
    const std::string letters = text(body.substr(6, 16));
    std::string_view labels = body.substr(22, 64);
    labels = labels.substr(0, labels.find('\0'));
    std::size_t at = 0;
    for (const char letter : letters) {
      const Letter* const known = letter_of(letter);
      if (known == nullptr) {
        return;
      }
      const std::size_t comma = std::min(labels.find(','), labels.size());
      type.fields.push_back({std::string(labels.substr(0, comma)), at, known, known->factor});
      labels.remove_prefix(std::min(comma + 1, labels.size()));
      at += known->bytes;
    }
    if (number == kFmt || at + kHeadBytes != type.bytes || !types_[number].records.empty()) {
      return;  // no new definition after a record of the type
    }
    types_[number] = std::move(type);
  }

  /// Field i of a record, as text.
  std::string text_of(const Type& type, std::size_t body, std::size_t i) const {
    return text(record(type, body).substr(type.fields[i].at, type.fields[i].letter->bytes));
  }
  double number_of(const Field& field, const Type& type, std::size_t body) const {
    const char* const at = record(type, body).data() + field.at;
    return field.letter->letter == 'g' ? read_half(at) : field.letter->read(at);
  }

  template <typename Take>
  void each(const char* name, std::size_t least_fields, Take&& take) {
    for (const Type& type : types_) {
      if (type.name == name && type.fields.size() >= least_fields) {
        for (const std::size_t body : type.records) {
          take(type, body);
        }
      }
    }
  }

  /// The letter that a row of UNIT or MULT explains, from its second column; empty if that is not a letter.
  std::optional<char> explained_letter(const Type& type, std::size_t body) const {
    const double code = is_number(type.fields[1]) ? number_of(type.fields[1], type, body) : -1.0;
    return code >= 0.0 && code < 128.0 ? std::optional(static_cast<char>(code)) : std::nullopt;
  }

  void take_units() {
    each("UNIT", 3, [&](const Type& type, std::size_t body) {
      const std::optional<char> letter = explained_letter(type, body);
      if (letter && !is_number(type.fields[2])) {
        unit_names_[*letter] = text_of(type, body, 2);
      }
    });
    each("FMTU", 4, [&](const Type& type, std::size_t body) {
      if (is_number(type.fields[1]) && type.fields[1].letter->bytes == 1 && !is_number(type.fields[2]) &&
          !is_number(type.fields[3])) {
        Type& about = types_[static_cast<std::size_t>(number_of(type.fields[1], type, body)) & 255U];
        about.units = text_of(type, body, 2);
        about.multipliers = text_of(type, body, 3);
      }
    });
    take_multipliers();
  }

  void take_multipliers() {
    std::map<char, double> multipliers;
    each("MULT", 3, [&](const Type& type, std::size_t body) {
      const std::optional<char> letter = explained_letter(type, body);
      if (letter && is_number(type.fields[2])) {
        multipliers[*letter] = number_of(type.fields[2], type, body);
      }
    });
    for (Type& type : types_) {
      set_factors(type, multipliers);
    }
  }

  static bool has_gps_week(const Type& type) {
    return std::any_of(type.fields.begin(), type.fields.end(),
                       [](const Field& field) { return field.label == "Week" || field.label == "GWk"; });
  }

  static void set_factors(Type& type, const std::map<char, double>& multipliers) {
    for (std::size_t i = 0; i < type.fields.size(); ++i) {
      Field& field = type.fields[i];
      const auto found = i < type.multipliers.size() ? multipliers.find(type.multipliers[i]) : multipliers.end();
      const bool given = found != multipliers.end() && std::isfinite(found->second) && found->second != 0.0;
      field.factor = field.letter->factor == 1.0 && given ? found->second : field.letter->factor;
      const bool is_ms = field.label == "TimeMS" || (field.label == "T" && has_gps_week(type));
      field.factor = field.label == "TimeUS" ? 1e-6 : is_ms ? 1e-3 : field.factor;
    }
  }

  std::string unit_of(char letter) const {
    const auto found = unit_names_.find(letter);
    return found == unit_names_.end() || letter == '-' ? "" : found->second;
  }

  /// The field that numbers several sensors of one type: it has the unit '#', or in logs without units the label "I".
  static const Field* instance_field(const Type& type) {
    for (std::size_t i = 0; i < type.fields.size(); ++i) {
      const bool marked = i < type.units.size() ? type.units[i] == '#' : type.fields[i].label == "I";
      if (marked && is_number(type.fields[i]) && type.fields[i].letter->bytes == 1) {
        return &type.fields[i];
      }
    }
    return nullptr;
  }

  std::vector<unsigned> instances(const Type& type) const {
    const Field* const field = instance_field(type);
    if (field == nullptr) {
      return {0};
    }
    std::array<bool, 256> seen{};
    for (const std::size_t body : type.records) {
      seen[static_cast<unsigned char>(record(type, body)[field->at])] = true;
    }
    std::vector<unsigned> out;
    for (unsigned i = 0; i < seen.size(); ++i) {
      if (seen[i]) {
        out.push_back(i);
      }
    }
    return out;
  }

  std::string stream_name(const Type& type, unsigned instance) const {
    return type.name + (instance_field(type) == nullptr || instance == 0 ? "" : ":" + std::to_string(instance));
  }

  std::vector<double> values(const Type& type, const Field& field, unsigned instance) const {
    const Field* const which = instance_field(type);
    std::vector<double> out;
    for (const std::size_t body : type.records) {
      if (which == nullptr || static_cast<unsigned char>(record(type, body)[which->at]) == instance) {
        out.push_back(field.factor * number_of(field, type, body));
      }
    }
    return out;
  }

  /// The clock of a message. In logs up to 2015, TimeMS in a message with a GPS week is the time of that week; the
  /// autopilot's own time then stands in T, or nowhere.
  std::vector<double> times(const Type& type, unsigned instance) const {
    const auto labelled = [&](const char* label) {
      return std::find_if(type.fields.begin(), type.fields.end(),
                          [&](const Field& field) { return field.label == label && is_number(field); });
    };
    const auto none = type.fields.end();
    auto clock = labelled("TimeUS");
    clock = clock == none ? labelled(has_gps_week(type) ? "T" : "TimeMS") : clock;
    return clock == none ? std::vector<double>{} : values(type, *clock, instance);
  }

  std::string bytes_;
  std::array<Type, 256> types_;
  std::map<std::string, std::size_t> by_name_;
  std::map<char, std::string> unit_names_;
  std::size_t lost_bytes_ = 0;
};

}  // namespace

std::unique_ptr<RawLog> open_ardupilot(const std::string& file) { return std::make_unique<ArduPilotLog>(file); }

}  // namespace m100::lab::logs
