// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iosfwd>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace m100 {

/// A JSON value lacks what is read from it, or is of another type; what() says which.
class JsonError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Json;

/// A container whose elements become an array, or an object if it is a map.
template <typename T>
concept JsonRange = !std::same_as<T, Json> && !std::convertible_to<const T&, std::string> &&
                    !std::convertible_to<const T&, std::string_view> && requires(const T& values) {
  values.begin();
  values.end();
};

/// A JSON value. An object keeps its names in the order of their insertion.
///
/// Only json.cpp includes the JSON library, because each source that includes it compiles a second longer.
class Json {
 public:
  struct Item {
    const std::string& key;
    const Json& value;
  };

  // Deviation: these constructors are implicit, so that a tree is written as {{"name", 1}, {"list", {1, 2}}}.
  Json(std::nullptr_t = nullptr) {}
  template <typename T>
  requires std::is_arithmetic_v<T> Json(T value) {
    if constexpr (std::floating_point<T>) {
      kind_ = Kind::kReal;
      real_ = static_cast<double>(value);
    } else {
      kind_ = std::same_as<T, bool> ? Kind::kBool : std::is_signed_v<T> ? Kind::kInteger : Kind::kUnsigned;
      whole_ = static_cast<std::uint64_t>(value);
    }
  }
  Json(std::string text) : kind_(Kind::kText), text_(std::move(text)) {}
  Json(std::string_view text) : Json(std::string(text)) {}
  Json(const char* text) : Json(std::string(text)) {}
  template <JsonRange T>
  Json(const T& values) {
    if constexpr (requires { typename T::mapped_type; }) {
      kind_ = Kind::kObject;
      for (const auto& [key, value] : values) {
        (*this)[key] = value;
      }
    } else {
      kind_ = Kind::kArray;
      for (const auto& value : values) {
        items_.emplace_back(value);
      }
    }
  }
  /// An object if each value is an array of a string and a value, else an array.
  Json(std::initializer_list<Json> values);
  static Json array(std::initializer_list<Json> values = {});
  static Json object();
  Json(const Json&);
  Json(Json&&) noexcept;
  Json& operator=(const Json&);
  Json& operator=(Json&&) noexcept;
  ~Json();

  /// @returns null if the text is not JSON, is nested more than 64 deep, or an object has more than 10000 names.
  static Json parse(std::string_view text);
  /// The value as text: in one line, or indented by that number of spaces. A number that is not finite becomes null. A
  /// byte that is not UTF-8 becomes the replacement character, so that an unprintable file name does not lose results.
  std::string dump(int indent = -1, bool ascii_only = false) const;
  /// The value with the names of all objects, inner ones too, in alphabetical order.
  Json sorted() const;

  bool is_null() const { return kind_ == Kind::kNull; }
  bool is_boolean() const { return kind_ == Kind::kBool; }
  bool is_string() const { return kind_ == Kind::kText; }
  bool is_array() const { return kind_ == Kind::kArray; }
  bool is_object() const { return kind_ == Kind::kObject; }
  bool is_number() const { return is_number_integer() || is_number_float(); }
  bool is_number_integer() const { return kind_ == Kind::kInteger || kind_ == Kind::kUnsigned; }
  bool is_number_unsigned() const { return kind_ == Kind::kUnsigned; }
  bool is_number_float() const { return kind_ == Kind::kReal; }

  /// The value as a bool, number, std::string, vector or map. Errors: JsonError if it is of another type.
  template <typename T>
  T get() const {
    if constexpr (std::same_as<T, Json>) {
      return *this;
    } else if constexpr (std::same_as<T, bool>) {
      return truth();
    } else if constexpr (std::floating_point<T>) {
      return static_cast<T>(number());
    } else if constexpr (std::integral<T>) {
      return static_cast<T>(whole_number());
    } else if constexpr (std::same_as<T, std::string>) {
      return text();
    } else if constexpr (requires { typename T::mapped_type; }) {
      T out;
      for (const auto& [key, value] : items()) {
        out[key] = value.template get<typename T::mapped_type>();
      }
      return out;
    } else {
      T out;
      for (const Json& value : elements()) {
        out.push_back(value.get<typename T::value_type>());
      }
      return out;
    }
  }
  /// The value of a name; `otherwise` if this object lacks it. Errors: JsonError if this is no object.
  template <typename T>
  T value(std::string_view key, const T& otherwise) const {
    const Json* const found = member("cannot use value() with ", key);
    return found != nullptr ? found->get<T>() : otherwise;
  }
  std::string value(std::string_view key, const char* otherwise) const { return value(key, std::string(otherwise)); }

  // An element of an array or a member of an object. Errors: JsonError if there is none, or this is of another type.
  // The changeable [key] inserts a missing member, and makes an object of null.
  const Json& at(std::size_t index) const;
  const Json& at(std::string_view key) const;
  template <std::integral Index>
  const Json& operator[](Index index) const {
    return at(static_cast<std::size_t>(index));
  }
  template <std::integral Index>
  Json& operator[](Index index) {
    return items_[static_cast<std::size_t>(&at(static_cast<std::size_t>(index)) - items_.data())];
  }
  const Json& operator[](std::string_view key) const { return at(key); }
  Json& operator[](std::string_view key);
  /// @returns end() if this is no object or lacks the name
  const Json* find(std::string_view key) const;
  bool contains(std::string_view key) const { return find(key) != end(); }
  void erase(std::string_view key);
  /// Adds the members of another object; those with the same names are replaced.
  void update(const Json& other);
  /// Adds an element. Makes an array of null.
  void push_back(Json value);

  std::size_t size() const { return static_cast<std::size_t>(end() - begin()); }
  bool empty() const { return size() == 0; }
  /// The elements of an array or the values of an object; null has none, and any other value is its own only element.
  const Json* begin() const { return is_structured_or_null() ? items_.data() : this; }
  const Json* end() const { return is_structured_or_null() ? items_.data() + items_.size() : this + 1; }
  Json* begin() { return is_structured_or_null() ? items_.data() : this; }
  Json* end() { return is_structured_or_null() ? items_.data() + items_.size() : this + 1; }
  /// The members of an object, which must outlive the list. Errors: JsonError if this is neither object nor null.
  std::vector<Item> items() const;

  /// Objects are equal if they have equal members in the same order.
  friend bool operator==(const Json& a, const Json& b);
  /// Unordered if this is no number.
  std::partial_ordering operator<=>(double other) const {
    return is_number() ? number() <=> other : std::partial_ordering::unordered;
  }
  friend std::ostream& operator<<(std::ostream& out, const Json& json);

 private:
  enum class Kind : std::uint8_t { kNull, kBool, kInteger, kUnsigned, kReal, kText, kArray, kObject };

  bool is_structured_or_null() const { return is_array() || is_object() || is_null(); }
  /// Throws JsonError(what, and the name of this type) if it is not so.
  void require(bool is_so, const char* what) const;
  bool truth() const;
  double number() const;
  std::uint64_t whole_number() const;
  const std::string& text() const;
  const std::vector<Json>& elements() const;
  const Json* member(const char* otherwise, std::string_view key) const;

  Kind kind_ = Kind::kNull;
  std::uint64_t whole_ = 0;  ///< a truth value, or an integer: if it is negative, in two's complement
  double real_ = 0.0;
  std::string text_;
  std::vector<std::string> names_;  ///< of an object: one for each item
  std::vector<Json> items_;
};

}  // namespace m100
