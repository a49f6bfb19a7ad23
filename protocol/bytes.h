// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>

namespace m100::protocol {

static_assert(std::endian::native == std::endian::little, "the wire is little-endian, and so is every machine we know");

/// A number of type T from its little-endian bytes; the caller guarantees sizeof(T) bytes.
template <typename T>
T load(const std::byte* bytes) {
  static_assert(std::is_arithmetic_v<T>);
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

/// Reads packed little-endian numbers in order. Reading past the end gives zeros and makes ok() false permanently, so a
/// decoder reads all fields first and checks once.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <typename T>
  T take() {
    if (rest_.size() < sizeof(T)) {
      ok_ = false;
      rest_ = {};
      return T{};
    }
    const T value = load<T>(rest_.data());
    rest_ = rest_.subspan(sizeof(T));
    return value;
  }

  template <typename T, std::size_t kCount>
  void take(std::array<T, kCount>& values) {
    for (T& value : values) {
      value = take<T>();
    }
  }

  std::span<const std::byte> rest() const { return rest_; }
  bool ok() const { return ok_; }
  /// Whether all bytes that were read existed, and none is left.
  bool complete() const { return ok_ && rest_.empty(); }

 private:
  std::span<const std::byte> rest_;
  bool ok_ = true;
};

/// Writes packed little-endian numbers in order. If one does not fit, it is not written, and ok() stays false.
class ByteWriter {
 public:
  explicit ByteWriter(std::span<std::byte> space) : space_(space) {}

  template <typename T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    if (space_.size() - size_ < sizeof(T)) {
      ok_ = false;
      return;
    }
    std::memcpy(space_.data() + size_, &value, sizeof(T));
    size_ += sizeof(T);
  }

  template <typename T, std::size_t kCount>
  void put(const std::array<T, kCount>& values) {
    for (const T& value : values) {
      put(value);
    }
  }

  void put(std::span<const std::byte> bytes) {
    if (space_.size() - size_ < bytes.size()) {
      ok_ = false;
      return;
    }
    if (!bytes.empty()) {
      std::memcpy(space_.data() + size_, bytes.data(), bytes.size());
    }
    size_ += bytes.size();
  }

  bool ok() const { return ok_; }
  std::size_t size() const { return size_; }
  std::span<std::byte> written() const { return space_.first(size_); }

 private:
  std::span<std::byte> space_;
  std::size_t size_ = 0;
  bool ok_ = true;
};

}  // namespace m100::protocol
