// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/text/json.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <ostream>
#include <utility>

namespace m100 {
namespace {

using Library = nlohmann::ordered_json;

// Our own files have at most 8 levels and a few hundred names. A deeper value would overflow the stack when it is
// copied, and an object compares each new name with all earlier ones.
constexpr std::size_t kDeepest = 64;
constexpr long kMaxNames = 10000;

/// @param quote index of the opening quote. @returns the index of the closing one; text.size() or more: there is none
std::size_t end_of_quoted(std::string_view text, std::size_t quote) {
  std::size_t at = quote + 1;
  while (at < text.size() && text[at] != '"') {
    at += text[at] == '\\' ? 2U : 1U;
  }
  return at;
}

/// Whether a text keeps kDeepest and kMaxNames.
bool is_modest(std::string_view text) {
  std::vector<long> commas;  // of each open bracket; an array's are so far below zero that they never reach the limit
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char letter = text[i];
    if (letter == '"') {
      i = end_of_quoted(text, i);
    } else if (letter == '{' || letter == '[') {
      commas.push_back(letter == '{' ? 0 : std::numeric_limits<long>::min());
    } else if ((letter == '}' || letter == ']') && !commas.empty()) {
      commas.pop_back();
    } else if (letter == ',' && !commas.empty()) {
      ++commas.back();
    }
    if (!commas.empty() && (commas.size() > kDeepest || commas.back() >= kMaxNames)) {
      return false;
    }
  }
  return true;
}

/// A value that is neither array nor object, from one type to the other: both have these functions.
template <typename To, typename From>
To scalar_as(const From& from) {
  return from.is_boolean()           ? To(from.template get<bool>())
         : from.is_number_unsigned() ? To(from.template get<std::uint64_t>())
         : from.is_number_integer()  ? To(from.template get<std::int64_t>())
         : from.is_number()          ? To(from.template get<double>())
         : from.is_string()          ? To(from.template get<std::string>())
                                     : To();
}

Library to_library(const Json& json) {
  if (json.is_object()) {
    Library::object_t out;
    for (const auto& [key, value] : json.items()) {
      out.emplace_back(key, to_library(value));
    }
    return out;
  }
  if (json.is_array()) {
    Library::array_t out;
    std::ranges::transform(json, std::back_inserter(out), to_library);
    return out;
  }
  return scalar_as<Library>(json);
}

Json from_library(const Library& library) {
  if (library.is_object()) {
    Json out = Json::object();
    for (const auto& [key, value] : library.items()) {
      out[key] = from_library(value);
    }
    return out;
  }
  if (library.is_array()) {
    Json out = Json::array();
    for (const Library& value : library) {
      out.push_back(from_library(value));
    }
    return out;
  }
  return scalar_as<Json>(library);
}

bool is_member(const Json& json) { return json.is_array() && json.size() == 2 && json[0].is_string(); }

}  // namespace

Json::Json(std::initializer_list<Json> values) : Json(array(values)) {
  if (std::ranges::all_of(values, is_member)) {
    kind_ = Kind::kObject;
    items_.clear();
    for (const Json& value : values) {
      if (!contains(value[0].text_)) {
        (*this)[value[0].text_] = value[1];
      }
    }
  }
}

Json Json::array(std::initializer_list<Json> values) {
  Json out;
  out.kind_ = Kind::kArray;
  out.items_ = values;
  return out;
}

Json Json::object() {
  Json out;
  out.kind_ = Kind::kObject;
  return out;
}

Json::Json(const Json&) = default;
Json::Json(Json&&) noexcept = default;
Json& Json::operator=(const Json&) = default;
Json& Json::operator=(Json&&) noexcept = default;
Json::~Json() = default;

Json Json::parse(std::string_view text) {
  return is_modest(text) ? from_library(Library::parse(text, nullptr, false)) : Json();
}

std::string Json::dump(int indent, bool ascii_only) const {
  return to_library(*this).dump(indent, ' ', ascii_only, Library::error_handler_t::replace);
}

Json Json::sorted() const {
  if (is_object()) {
    std::map<std::string, Json> out;
    for (const auto& [key, value] : items()) {
      out.emplace(key, value.sorted());
    }
    return out;
  }
  Json out = *this;
  std::ranges::transform(items_, out.items_.begin(), &Json::sorted);
  return out;
}

const Json& Json::at(std::size_t index) const {
  require(is_array(), "cannot use at() with ");
  if (index >= items_.size()) {
    throw JsonError("array index " + std::to_string(index) + " is out of range");
  }
  return items_[index];
}

const Json& Json::at(std::string_view key) const {
  const Json* const found = member("cannot use at() with ", key);
  if (found == nullptr) {
    throw JsonError("key '" + std::string(key) + "' not found");
  }
  return *found;
}

Json& Json::operator[](std::string_view key) {
  kind_ = is_null() ? Kind::kObject : kind_;
  const Json* const found = member("cannot use operator[] with a string argument with ", key);
  if (found != nullptr) {
    return items_[static_cast<std::size_t>(found - items_.data())];
  }
  names_.emplace_back(key);
  return items_.emplace_back();
}

const Json* Json::find(std::string_view key) const {
  const auto name = std::ranges::find(names_, key);
  return name == names_.end() ? end() : begin() + (name - names_.begin());
}

void Json::erase(std::string_view key) {
  if (const auto name = std::ranges::find(names_, key); name != names_.end()) {
    items_.erase(items_.begin() + (name - names_.begin()));
    names_.erase(name);
  }
}

void Json::update(const Json& other) {
  other.require(other.is_object(), "cannot use update() with ");
  for (const auto& [key, value] : other.items()) {
    (*this)[key] = value;
  }
}

void Json::push_back(Json value) {
  kind_ = is_null() ? Kind::kArray : kind_;
  require(is_array(), "cannot use push_back() with ");
  items_.push_back(std::move(value));
}

std::vector<Json::Item> Json::items() const {
  require(is_object() || is_null(), "cannot use items() with ");
  std::vector<Item> out;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    out.push_back({names_[i], items_[i]});
  }
  return out;
}

bool operator==(const Json& a, const Json& b) {
  if (a.is_number() && b.is_number()) {
    return a.is_number_float() || b.is_number_float() ? a.number() == b.number() : a.whole_ == b.whole_;
  }
  return a.kind_ == b.kind_ && a.whole_ == b.whole_ && a.text_ == b.text_ && a.names_ == b.names_ &&
         a.items_ == b.items_;
}

std::ostream& operator<<(std::ostream& out, const Json& json) { return out << json.dump(); }

void Json::require(bool is_so, const char* what) const {
  constexpr std::array kNames{"null", "boolean", "number", "number", "number", "string", "array", "object"};
  if (!is_so) {
    throw JsonError(std::string(what) + kNames[static_cast<std::size_t>(kind_)]);
  }
}

bool Json::truth() const {
  require(is_boolean(), "type must be boolean, but is ");
  return whole_ != 0;
}

double Json::number() const {
  require(is_number(), "type must be number, but is ");
  return is_number_float()      ? real_
         : is_number_unsigned() ? static_cast<double>(whole_)
                                : static_cast<double>(static_cast<std::int64_t>(whole_));
}

std::uint64_t Json::whole_number() const {
  constexpr double kLargest = 9e18;  // what is larger does not fit into an integer
  const double value = number();
  if (is_number_float() && !(value > -kLargest && value < kLargest)) {
    throw JsonError("number is out of range");
  }
  return is_number_float() ? static_cast<std::uint64_t>(static_cast<std::int64_t>(value)) : whole_;
}

const std::string& Json::text() const {
  require(is_string(), "type must be string, but is ");
  return text_;
}

const std::vector<Json>& Json::elements() const {
  require(is_array(), "type must be array, but is ");
  return items_;
}

const Json* Json::member(const char* otherwise, std::string_view key) const {
  require(is_object(), otherwise);
  const Json* const found = find(key);
  return found == end() ? nullptr : found;
}

}  // namespace m100
