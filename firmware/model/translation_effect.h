// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/core/maths.h"
#include "firmware/model/in_flight.h"

namespace m100::model {

// The interface of a translation effect: something besides thrust and gravity that moves the vehicle, or that makes its
// thrust look different. Each effect is one file in firmware/model/translation. The vehicle file, the simulated
// aircraft, identification and reports read what the file declares.

/// World frame, z up.
using Acceleration = std::array<double, 3>;

/// One moment of a flight, as the law of an effect sees it. World frame, z up.
struct Moment {
  double time_s = 0.0;
  std::array<double, 3> air_velocity_w_m_s{};  ///< of the vehicle relative to the air
  Acceleration thrust_w_m_s2{};                ///< thrust over mass
  std::array<double, 3> up_b_in_w{};           ///< the body's z axis
  double heading_cosine = 1.0;
  double heading_sine = 0.0;
};

/// A whole log's thrust, which an effect may change in place. All spans have the same length.
struct ThrustSeries {
  double period_s;
  std::span<double> thrust_m_s2;
  std::array<std::span<double>, 3> direction_w;  ///< the body's z axis
  std::span<double> spare;                       ///< scratch for a copy of one of the series
};

/// One reported number of an effect.
struct EffectParameter {
  std::string_view name = {};  ///< with its unit, as the JSON spells it; empty: there is none
  double low = 0.0;            ///< physical bounds; a fit outside of them is no evidence of the effect
  double high = 0.0;
  double neutral = 0.0;       ///< the value with which the effect is absent
  std::string_view key = {};  ///< in the vehicle file; empty: the file has no place for it
  bool only_if_set = false;   ///< not written while neutral, so that older files keep their digest
};

/// How the search begins for a parameter in which the prediction is not linear.
enum class Start : std::uint8_t {
  kGrid,           ///< from each of the given values
  kStrongestPeak,  ///< from the strongest spectral peak of what the other effects leave
  kWindSpeed,      ///< from the steady acceleration; searched only beside a drag that grows faster than the speed
};

/// One parameter in which the prediction is not linear.
struct SearchedParameter {
  double low = 0.0;
  double high = 0.0;  ///< not above low: there is no such parameter
  double first_step = 0.0;
  double last_step = 0.0;
  double repeated_step = 0.0;  ///< when a fit is repeated on other blocks
  int turn = 0;                ///< order in the coordinate search
  Start start = Start::kGrid;
  std::array<double, 4> values{};  ///< of a grid
  std::size_t value_count = 0;
};

/// How identification looks for an effect that begins, ends or changes its size in flight.
struct MidFlightForce {
  std::string_view name = {};  ///< in the result; empty: no change of this effect is looked for
  std::string_view unit = {};  ///< of the reported change, as the JSON spells it
  double min_relevant = 0.0;   ///< a smaller change is not named
};

/// What a log must have for an effect to show in it.
struct Needs {
  bool velocity = false;
  bool thrust_set_point = false;
  bool tilt_in_thrust = false;  ///< acceleration not from the accelerometer, whose x and y do not show thrust
};

/// How an effect acts on the vehicle.
enum class Acts : std::uint8_t {
  kAsForce,   ///< an outer force: an accelerometer measures it, and a thrust measured by one contains a part of it
  kInThrust,  ///< a change of the thrust itself
  kOnThrust,  ///< beside the thrust, and along it in part: a thrust measured by an accelerometer contains that part
};

/// How an effect depends on the velocity relative to the air, and with it on the wind.
enum class Drag : std::uint8_t {
  kNone,
  kProportional,  ///< the effect of a wind is then a constant acceleration
  kProgressive,   ///< the speed of the wind matters, not only the acceleration that it causes
};

double first_of(std::span<const double> parameters);

/// All that a translation effect declares. The prediction is
///   a = thrust vector - g + sum over effects of columns * linear parameters, after each reshape() of the thrust.
struct TranslationEffect {
  static constexpr std::size_t kMaxParameters = 3;
  static constexpr std::size_t kMaxSearched = 2;

  std::string_view name;
  int place = 0;  ///< in files, tables and in the search: lower numbers come first, and no two are equal
  Needs needs = {};
  std::array<EffectParameter, kMaxParameters> parameters = {};
  double min_relevant = 0.0;  ///< a smaller size() does not matter to a controller
  double (*size)(std::span<const double> parameters) = first_of;

  std::size_t columns = 0;  ///< number of linear parameters; not used while the speed of a wind is searched instead
  /// Acceleration for a linear parameter that is 1. `searched` is the effect's first searched parameter, or 0.
  Acceleration (*column)(std::size_t which, const Moment& at, double searched) = nullptr;
  Acts acts = Acts::kAsForce;
  Drag drag = Drag::kNone;

  std::array<SearchedParameter, kMaxSearched> searched = {};
  void (*reshape)(const ThrustSeries& series, double searched) = nullptr;
  bool is_periodic = false;  ///< a force with a period: must stay in phase, and not be the vehicle's own motion

  /// The reported numbers; null: they are the linear parameters.
  void (*report)(std::span<const double> searched, std::span<const double> linear, std::span<double> out) = nullptr;
  std::string_view equivalent = {};  ///< the effect that is the same as this one while the heading is constant

  MidFlightForce change = {};

  InFlight in_flight = InFlight::kNowhere;
  std::string_view sentence;          ///< what the finding means for the flight
  std::string_view not_in_file = {};  ///< why the vehicle file has no place for it, after the effect's name

  constexpr std::size_t parameter_count() const {
    std::size_t count = 0;
    while (count < kMaxParameters && !parameters[count].name.empty()) {
      ++count;
    }
    return count;
  }
  constexpr std::size_t searched_count() const {
    std::size_t count = 0;
    while (count < kMaxSearched && searched[count].low < searched[count].high) {
      ++count;
    }
    return count;
  }
  constexpr bool has_key() const { return !parameters[0].key.empty(); }
  /// Whether the simulated world can contain it: an outer force that the keys of the vehicle file describe in full.
  constexpr bool can_be_simulated() const {
    return has_key() && acts == Acts::kAsForce && columns == parameter_count() && searched_count() == 0;
  }
};

// Sizes that several effects share.

/// The first parameter with its sign. A negative value is therefore never a relevant size.
inline double first_of(std::span<const double> parameters) { return parameters[0]; }
inline double magnitude(std::span<const double> parameters) {
  return parameters[0] < 0.0 ? -parameters[0] : parameters[0];
}
inline double length_of_two(std::span<const double> parameters) {
  return core::sqrt(parameters[0] * parameters[0] + parameters[1] * parameters[1]);
}
inline double distance_from_one(std::span<const double> parameters) {
  return parameters[0] < 1.0 ? 1.0 - parameters[0] : parameters[0] - 1.0;
}

// Reports that several effects share.

inline void report_searched(std::span<const double> searched, std::span<const double>, std::span<double> out) {
  out[0] = searched[0];
}
inline void report_gain(std::span<const double>, std::span<const double> linear, std::span<double> out) {
  out[0] = 1.0 + linear[0];
}

/// Largest acceleration that air or an unbalance can cause.
inline constexpr double kMaxAcceleration_m_s2 = 20.0;

}  // namespace m100::model
