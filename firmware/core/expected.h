// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <type_traits>

#include "firmware/core/assert.h"
#include "firmware/core/status.h"

namespace m100::core {

/// A T, or the Status that says why there is none. No heap, no exceptions; T must be trivially destructible and default
/// constructible, which everything in the tick is.
template <typename T>
class [[nodiscard]] Expected {
  static_assert(std::is_trivially_destructible_v<T>);

 public:
  constexpr Expected(const T& value) : value_(value), status_(Status::kOk) {}  // NOLINT: conversion is the point
  constexpr Expected(Status status) : value_{}, status_(status) { M100_ASSERT(status != Status::kOk); }  // NOLINT

  constexpr bool has_value() const { return status_ == Status::kOk; }
  constexpr explicit operator bool() const { return has_value(); }
  constexpr Status status() const { return status_; }

  /// The value. M100_ASSERT fails if there is none.
  constexpr const T& value() const {
    M100_ASSERT(has_value());
    return value_;
  }
  constexpr const T& operator*() const { return value(); }
  constexpr const T* operator->() const { return &value(); }
  constexpr T value_or(const T& fallback) const { return has_value() ? value_ : fallback; }

 private:
  T value_;
  Status status_;
};

}  // namespace m100::core
