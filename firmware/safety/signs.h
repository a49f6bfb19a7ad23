// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <type_traits>

namespace m100::safety {

/// A sign is one condition that a table tests; a value of the enumeration is a set of them, one bit each. The ladder
/// and the authority table each have their own enumeration and share these functions.
template <typename S>
inline constexpr bool kIsSign = false;
template <typename S>
concept SignSet = kIsSign<S>;

template <SignSet S>
constexpr std::underlying_type_t<S> bits_of(S set) {
  return static_cast<std::underlying_type_t<S>>(set);
}
template <SignSet S>
constexpr S operator|(S a, S b) {
  return static_cast<S>(bits_of(a) | bits_of(b));
}
template <SignSet S>
constexpr S operator&(S a, S b) {
  return static_cast<S>(bits_of(a) & bits_of(b));
}
template <SignSet S>
constexpr S operator~(S a) {
  return static_cast<S>(~bits_of(a));
}
template <SignSet S>
constexpr S& operator|=(S& a, S b) {
  return a = a | b;
}
/// The sign if the condition is true, otherwise none.
template <SignSet S>
constexpr S when(bool condition, S sign) {
  return condition ? sign : S::kNone;
}
template <SignSet S>
constexpr bool any(S set, std::type_identity_t<S> wanted) {
  return (set & wanted) != S::kNone;
}
template <SignSet S>
constexpr bool all(S set, std::type_identity_t<S> wanted) {
  return (set & wanted) == wanted;
}

}  // namespace m100::safety
