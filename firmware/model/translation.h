// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "firmware/core/assert.h"
#include "firmware/model/translation_effect.h"
// Generated when the build is configured: includes every effect of the folder `translation` and lists their types.
#include "firmware/model/translation_list.h"

namespace m100::model {

namespace translation {

/// Combines the numbers of several effects as members of one struct.
template <typename... Effects>
struct Together : Effects... {};

/// One number that a vehicle file may hold.
template <typename Struct>
struct Number {
  std::string_view key;
  double Struct::*member = nullptr;
  double low = 0.0;
  double high = 0.0;
  double neutral = 0.0;
  bool only_if_set = false;
  int place = 0;  ///< position in the file
};

constexpr bool comes_before(const auto& a, const auto& b) { return a.place < b.place; }

template <typename Row, std::size_t kCount>
constexpr std::array<Row, kCount> in_order(std::array<Row, kCount> rows) {
  for (std::size_t i = 1; i < kCount; ++i) {
    for (std::size_t k = i; k > 0 && comes_before(rows[k], rows[k - 1]); --k) {
      const Row swapped = rows[k];
      rows[k] = rows[k - 1];
      rows[k - 1] = swapped;
    }
  }
  return rows;
}

/// The combined declarations of the listed types.
template <typename List>
struct Tables;

template <typename... Effects>
struct Tables<List<Effects...>> {
  using Numbers = Together<Effects...>;

  static constexpr std::array<TranslationEffect, sizeof...(Effects)> effects() {
    return in_order(std::array{Effects::kEffect...});
  }

  template <typename Effect>
  static constexpr std::size_t number_count() {
    if constexpr (requires { Effect::kMembers; }) {
      static_assert(Effect::kMembers.size() == Effect::kEffect.parameter_count(), "one member for each parameter");
      return Effect::kMembers.size();
    }
    return 0;
  }
  static constexpr std::size_t kNumbers = (number_count<Effects>() + ... + 0);

  template <typename Effect>
  static constexpr void add(std::array<Number<Numbers>, kNumbers>& rows, std::size_t& at) {
    if constexpr (number_count<Effect>() > 0) {
      for (std::size_t k = 0; k < number_count<Effect>(); ++k) {
        const EffectParameter& from = Effect::kEffect.parameters[k];
        rows[at++] = {from.key,
                      Effect::kMembers[k],
                      from.low,
                      from.high,
                      from.neutral,
                      from.only_if_set,
                      Effect::kEffect.place + static_cast<int>(k)};
      }
    }
  }
  static constexpr std::array<Number<Numbers>, kNumbers> numbers() {
    std::array<Number<Numbers>, kNumbers> rows{};
    std::size_t at = 0;
    (add<Effects>(rows, at), ...);
    return in_order(rows);
  }
};

using All = Tables<Listed>;

}  // namespace translation

/// Every effect of translation, in file order.
inline constexpr auto kTranslationEffects = translation::All::effects();

/// The numbers of all effects that a vehicle file may hold, each a member with the name of its key. The simulated air
/// has the same members.
using TranslationNumbers = translation::All::Numbers;
inline constexpr auto kEffectNumbers = translation::All::numbers();

/// The controller's model of horizontal motion:
///   v' = tilt_gain g tan(tilt) - drag(v - wind) + disturbance, about hover.
struct Translation : TranslationNumbers {
  double mass_kg = 3.3;                         ///< paper, IV-A
  double tilt_limit_rad = 0.43633231299858238;  ///< 25 deg

  /// A copy with one number changed. The key must be one of kTranslationNumbers.
  constexpr Translation with(std::string_view key, double value) const;
};

/// The keys of the section [translation] of a vehicle file, in file order.
inline constexpr auto kTranslationNumbers = [] {
  using Number = translation::Number<Translation>;
  std::array<Number, kEffectNumbers.size() + 2> rows{};
  rows[0] = {"mass_kg", &Translation::mass_kg, 0.5, 20.0, 0.0, false, 0};
  rows[1] = {"tilt_limit_rad", &Translation::tilt_limit_rad, 0.05, 0.7, 0.0, false, 45};
  for (std::size_t k = 0; k < kEffectNumbers.size(); ++k) {
    const auto& from = kEffectNumbers[k];
    rows[k + 2] = {from.key, from.member, from.low, from.high, from.neutral, from.only_if_set, from.place};
  }
  return translation::in_order(rows);
}();

constexpr Translation Translation::with(std::string_view key, double value) const {
  Translation out = *this;
  for (const auto& number : kTranslationNumbers) {
    if (number.key == key) {
      out.*number.member = value;
      return out;
    }
  }
  M100_ASSERT(false);  // in a constant expression this does not compile
  return out;
}

/// The effect of that name; null if there is none.
constexpr const TranslationEffect* translation_effect(std::string_view name) {
  for (const TranslationEffect& effect : kTranslationEffects) {
    if (effect.name == name) {
      return &effect;
    }
  }
  return nullptr;
}

/// Whether the key belongs to an effect that the simulated world can contain.
constexpr bool simulated(std::string_view key) {
  for (const TranslationEffect& effect : kTranslationEffects) {
    for (const EffectParameter& parameter : effect.parameters) {
      if (parameter.key == key) {
        return effect.can_be_simulated();
      }
    }
  }
  return false;
}

/// The value of the member with that key; the key must be one of kEffectNumbers.
constexpr double number_of(const TranslationNumbers& numbers, std::string_view key) {
  for (const auto& number : kEffectNumbers) {
    if (number.key == key) {
      return numbers.*number.member;
    }
  }
  M100_ASSERT(false);
  return 0.0;
}

/// Acceleration of a vehicle by the effects that can be simulated, which are external forces, with these numbers.
/// @param share  the mass for which the numbers are valid, divided by the vehicle's mass
inline Acceleration outer_acceleration(const TranslationNumbers& numbers, const Moment& at, double share) {
  Acceleration sum{};
  for (const TranslationEffect& effect : kTranslationEffects) {
    for (std::size_t k = 0; effect.can_be_simulated() && k < effect.columns; ++k) {
      const double value = number_of(numbers, effect.parameters[k].key);
      if (value != effect.parameters[k].neutral) {
        const Acceleration column = effect.column(k, at, 0.0);
        for (std::size_t axis = 0; axis < sum.size(); ++axis) {
          sum[axis] += share * value * column[axis];
        }
      }
    }
  }
  return sum;
}

}  // namespace m100::model
