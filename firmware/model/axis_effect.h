// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string_view>

#include "firmware/model/in_flight.h"
#include "firmware/model/stick_axis.h"

namespace m100::model {

// The types of the rows of the table of axis effects (axis_effects.h).

/// The unit of an axis; it selects the key of a number in a vehicle file and its range (FileEntry).
enum class AxisUnit : std::uint8_t { kTilt_rad, kYawRate_rad_s, kClimb_m_s };

struct Bounds {
  double low = 0.0;
  double high = 0.0;
};

/// At most kMax elements, in the order given.
template <typename T, std::size_t kMax>
struct InlineVector {
  std::array<T, kMax> items{};
  std::size_t count = 0;
  constexpr InlineVector(std::initializer_list<T> list) {
    for (const T& item : list) {
      items[count++] = item;
    }
  }
  constexpr const T* begin() const { return items.data(); }
  constexpr const T* end() const { return items.data() + count; }
  constexpr std::size_t size() const { return count; }
  constexpr const T& operator[](std::size_t at) const { return items[at]; }
};

/// Key and range of a number in vehicle and plant files, and its place, which orders the numbers of a section. A number
/// at kLate comes last and is written only if it is set.
struct FileEntry {
  static constexpr int kLate = 100;
  std::array<std::string_view, 3> key{};  ///< by AxisUnit; empty: a section of that axis has no such key
  std::array<Bounds, 3> range{};          ///< by AxisUnit
  int place = kLate;                      ///< in roll and pitch
  int place_of_rates = kLate;             ///< in yaw rate and climb
  constexpr bool exists(AxisUnit unit) const { return !key[static_cast<std::size_t>(unit)].empty(); }
};
constexpr FileEntry everywhere(std::string_view key, Bounds range, int place = FileEntry::kLate,
                               int place_of_rates = FileEntry::kLate) {
  return {{key, key, key}, {range, range, range}, place, place_of_rates};
}

/// How identification looks for a number that changes in flight.
struct MidFlight {
  /// The unit of `step`, `low`, `high` and `min_relevant`.
  enum class Of : std::uint8_t {
    kPlain,   ///< the number's own
    kItself,  ///< the number's magnitude
    kStick,   ///< step and min_relevant: one count of the log's stick; low and high: its largest deflection
  };
  std::string_view name{};    ///< in the result; empty: no change of this number is looked for
  std::string_view suffix{};  ///< of the reported values before and after: their unit
  Of of = Of::kPlain;
  double step = 0.0;  ///< of the numerical derivative
  double low = 0.0;   ///< bounds of the value before and after the change
  double high = 0.0;
  double min_relevant = 0.0;  ///< a smaller change is not named
  bool at_the_stick = false;  ///< it acts before the transport delay
};

/// One number of an effect. Fits work in units of what the data show (FitUnit), so that bounds suit any aircraft.
struct AxisNumber {
  enum class FitUnit : std::uint8_t {
    kPlain,    ///< the number's own unit
    kStick,    ///< largest deflection of the stick in the log
    kCommand,  ///< largest response
    kRate,     ///< largest slope of the response
    kGain,     ///< first guess of the scale
  };
  std::string_view parameter;  ///< name in reports and JSON
  double StickAxis::*member = nullptr;
  std::string_view field{};  ///< name of the member, if it differs from the key of roll and pitch
  FileEntry file{};
  FitUnit unit = FitUnit::kPlain;
  Bounds fit{};               ///< bounds in `unit`; a fit that ends at one is no effect but a misfit
  bool logarithmic = false;   ///< fitted as its logarithm
  double step = 2e-4;         ///< of the numerical derivative: small against what matters, large against kinks
  double min_relevant = 0.0;  ///< smallest relevant distance from `neutral`; of the logarithms if `logarithmic`
  double neutral = 0.0;
  MidFlight change{};
  constexpr std::string_view field_name() const { return field.empty() ? file.key[0] : field; }
};

/// A medium size of the effect's first number, for forecasts and for additions to measured flights. It is `size`
/// itself, the axis' own number plus `size`, or `size` times the largest response or the largest rate of the response.
struct Typical {
  enum class Of : std::uint8_t { kAlone, kBesideOwn, kLargestResponse, kFastestResponse };
  double size = 0.0;  ///< 0: the effect is not made this way
  Of of = Of::kAlone;
};

struct AxisEffect {
  std::string_view name;
  InlineVector<AxisNumber, 3> numbers{};
  InlineVector<std::array<double, 3>, 3> starts{};  ///< of a fit, in the units of the numbers; one row per start
  std::string_view variant{};                       ///< a second form of the effect, fitted too
  std::string_view needs{};                         ///< the effect that it requires
  std::string_view not_beside{};                    ///< the effect that contains it: never both
  bool needs_other_stick = false;
  bool of_response = false;     ///< acts behind delay and dynamics (ResponseLaw), not on the stick
  bool in_every_model = false;  ///< a nuisance parameter: always fitted, an effect where it leaves its neutral
  Typical typical{};
  InFlight in_flight = InFlight::kLeftToTheObserver;
  std::string_view sentence{};  ///< what it means for the flight
};

}  // namespace m100::model
