// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <type_traits>

namespace m100::safety {

/// True for an enumeration whose values are sets of conditions, one bit each. Such enumerations share the functions
/// below.
template <typename S>
inline constexpr bool kIsCondition = false;
template <typename S>
concept ConditionSet = kIsCondition<S>;

template <ConditionSet S>
constexpr std::underlying_type_t<S> bits_of(S set) {
  return static_cast<std::underlying_type_t<S>>(set);
}
template <ConditionSet S>
constexpr S operator|(S a, S b) {
  return static_cast<S>(bits_of(a) | bits_of(b));
}
template <ConditionSet S>
constexpr S operator&(S a, S b) {
  return static_cast<S>(bits_of(a) & bits_of(b));
}
template <ConditionSet S>
constexpr S operator~(S a) {
  return static_cast<S>(~bits_of(a));
}
template <ConditionSet S>
constexpr S& operator|=(S& a, S b) {
  return a = a | b;
}
/// `sign` if the condition is true, otherwise the empty set.
template <ConditionSet S>
constexpr S when(bool condition, S sign) {
  return condition ? sign : S::kNone;
}
template <ConditionSet S>
constexpr bool any(S set, std::type_identity_t<S> wanted) {
  return (set & wanted) != S::kNone;
}
template <ConditionSet S>
constexpr bool all(S set, std::type_identity_t<S> wanted) {
  return (set & wanted) == wanted;
}

}  // namespace m100::safety
