// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstring>

namespace m100::lab::logs {

/// A number in this machine's order of bytes, at any address.
template <typename T>
T read_number(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

template <typename T>
double read_as(const char* bytes) {
  return static_cast<double>(read_number<T>(bytes));
}

}  // namespace m100::lab::logs
