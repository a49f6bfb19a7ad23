// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/formats/ulog_format.h"

#include <algorithm>
#include <charconv>
#include <cstdint>

#include "host_tests/lab/logs/formats/read_number.h"

namespace m100::lab::logs {
namespace {

struct Basic {
  std::size_t bytes;
  double (*read)(const char*);
};

const Basic* basic(std::string_view type) {
  static const std::map<std::string, Basic, std::less<>> types{
      {"int8_t", {1, &read_as<std::int8_t>}},   {"uint8_t", {1, &read_as<std::uint8_t>}},
      {"bool", {1, &read_as<std::uint8_t>}},    {"char", {1, &read_as<std::uint8_t>}},
      {"int16_t", {2, &read_as<std::int16_t>}}, {"uint16_t", {2, &read_as<std::uint16_t>}},
      {"int32_t", {4, &read_as<std::int32_t>}}, {"uint32_t", {4, &read_as<std::uint32_t>}},
      {"int64_t", {8, &read_as<std::int64_t>}}, {"uint64_t", {8, &read_as<std::uint64_t>}},
      {"float", {4, &read_as<float>}},          {"double", {8, &read_as<double>}}};
  const auto found = types.find(type);
  return found == types.end() ? nullptr : &found->second;
}

/// "name[3]" split into name and number; without brackets there is no number. nullopt: the brackets hold no number.
struct Step {
  std::string_view name;
  std::optional<std::size_t> index;
};
std::optional<Step> step_of(std::string_view text) {
  const std::size_t open = text.find('[');
  if (open == std::string_view::npos) {
    return Step{text, std::nullopt};
  }
  std::size_t index = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data() + open + 1, end, index);
  if (error != std::errc{} || stop + 1 != end || *stop != ']') {
    return std::nullopt;
  }
  return Step{text.substr(0, open), index};
}

bool is_padding(std::string_view name) { return name.starts_with("_padding"); }

}  // namespace

bool UlogFormats::define(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos || colon == 0) {
    return false;
  }
  Format format;
  format.text = text.substr(colon + 1);
  formats_.insert_or_assign(std::string(text.substr(0, colon)), std::move(format));
  return true;
}

const UlogFormats::Format* UlogFormats::resolved(const std::string& name, int depth) {
  const auto found = formats_.find(name);
  if (found == formats_.end() || depth > kDeepest) {
    return nullptr;
  }
  Format& format = found->second;
  if (!format.resolved) {
    format.resolved = true;
    format.broken = true;  // while it is evaluated, because a format inside itself has no size
    format.broken = !resolve(format, depth);
  }
  return format.broken ? nullptr : &format;
}

bool UlogFormats::measure(Field& field, int depth) {
  const Basic* const plain = basic(field.type);
  const Format* const nested = plain == nullptr ? resolved(field.type, depth + 1) : nullptr;
  if (plain == nullptr && nested == nullptr) {
    return false;
  }
  field.each = plain != nullptr ? plain->bytes : nested->bytes;
  field.named = !is_padding(field.name) && (plain != nullptr || nested->named);
  return true;
}

bool UlogFormats::resolve(Format& format, int depth) {
  std::string_view rest = format.text;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(';'), rest.size());
    const std::string_view one = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    const std::size_t space = one.find(' ');
    if (one.empty()) {
      continue;
    }
    const auto type = step_of(one.substr(0, std::min(space, one.size())));
    if (space == std::string_view::npos || space + 1 >= one.size() || !type) {
      return false;
    }
    Field field{.name = std::string(one.substr(space + 1)),
                .type = std::string(type->name),
                .is_array = type->index.has_value(),
                .count = type->index.value_or(1),
                .at = format.bytes};
    if (!measure(field, depth)) {
      return false;
    }
    if (field.each > 0 && field.count > (kMaxBytes - format.bytes) / field.each) {
      return false;
    }
    format.bytes += field.count * field.each;
    format.named = format.named || (field.named && field.count > 0);
    format.fields.push_back(std::move(field));
  }
  return true;
}

std::optional<UlogNumber> UlogFormats::find(const std::string& name, std::string_view path) {
  const Format* format = resolved(name, 0);
  std::size_t at = 0;
  while (format != nullptr) {
    const std::size_t dot = path.find('.');
    const auto step = step_of(path.substr(0, dot));
    if (!step) {
      return std::nullopt;
    }
    const auto field = std::find_if(format->fields.begin(), format->fields.end(),
                                    [&](const Field& one) { return one.name == step->name; });
    if (field == format->fields.end() || field->is_array != step->index.has_value() ||
        step->index.value_or(0) >= field->count) {
      return std::nullopt;
    }
    at += field->at + step->index.value_or(0) * field->each;
    if (const Basic* const plain = basic(field->type)) {
      return dot == std::string_view::npos ? std::optional(UlogNumber{at, plain->bytes, plain->read}) : std::nullopt;
    }
    if (dot == std::string_view::npos) {
      return std::nullopt;
    }
    path.remove_prefix(dot + 1);
    format = resolved(field->type, 0);
  }
  return std::nullopt;
}

void UlogFormats::list(const std::string& name, const std::string& prefix, std::size_t most,
                       std::vector<std::string>& out) {
  const Format* const format = resolved(name, 0);
  if (format == nullptr) {
    return;
  }
  for (const Field& field : format->fields) {
    const bool plain = basic(field.type) != nullptr;
    const std::size_t count = field.named ? field.count : 0;
    for (std::size_t i = 0; i < count && out.size() < most; ++i) {
      const std::string full = prefix + field.name + (field.is_array ? "[" + std::to_string(i) + "]" : "");
      plain ? out.push_back(full) : list(field.type, full + ".", most, out);
    }
  }
}

std::vector<std::string> UlogFormats::fields(const std::string& name, std::size_t most) {
  std::vector<std::string> out;
  const Format* const format = resolved(name, 0);
  if (format == nullptr) {
    return out;
  }
  for (const Field& field : format->fields) {
    if (field.named && out.size() < most) {
      out.push_back(field.name + (field.is_array ? "[" + std::to_string(field.count) + "]" : "") +
                    (basic(field.type) == nullptr ? "." : ""));
    }
  }
  return out;
}

}  // namespace m100::lab::logs
