// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/core/eigen.h"
#include "host_tests/sim/world/random.h"

namespace m100::scenario {

/// One channel's value: up to three numbers, in the channel's unit; unused ones are zero.
using Value = core::Vector<double, 3>;

/// What one piece of a waveform does to a value. `size` is in the channel's unit unless stated otherwise.
enum class WaveformShape : std::uint8_t {
  kBias,     ///< adds the size along the direction
  kDrift,    ///< adds the size times the time (unit/s); the offset remains when the piece ends
  kSwing,    ///< adds a sine of this amplitude, whose period is fade_s
  kDelay,    ///< the value as it was `size` seconds ago
  kGain,     ///< multiplies the change since the piece began by 1 + size (no unit)
  kNoise,    ///< adds white noise of this standard deviation, along the direction
  kDropout,  ///< no value
  kSign,     ///< mirrors the change since the piece began, along the direction
};
inline constexpr std::array<std::string_view, 8> kShapeNames{"bias", "drift", "swing",   "delay",
                                                             "gain", "noise", "dropout", "sign"};

/// One fault in a channel for a limited time. It fades in over `fade_s`, so that it can begin without a jump.
struct Piece {
  WaveformShape shape = WaveformShape::kBias;
  double from_s = 0.0;  ///< from the beginning of the course
  double for_s = 1.0;
  double fade_s = 0.0;
  double size = 0.0;
  Value direction = Value::UnitX();
};
using Waveform = std::vector<Piece>;

/// Text form: "drift 2 20 0.5 0.3 1 0 0; ...", a piece's members in order. @throws std::invalid_argument if malformed.
std::string to_text(const Waveform& wave);
Waveform waveform_of(const std::string& text);

/// Falsifies a channel's values according to a waveform. Values must come in the order of time.
class WaveformInjector {
 public:
  WaveformInjector(Waveform wave, std::uint64_t seed);
  /// @param anchored gain and sign refer to the value at which the piece began, otherwise to zero.
  /// @returns the false value; empty for a dropout.
  std::optional<Value> apply(double t_s, const Value& truth, bool anchored);

 private:
  Value changed(std::size_t index, double t_s, const Value& value, const Value& truth);
  Value delayed_value(double t_s) const;

  struct TimedValue {
    double t_s;
    Value truth;
  };
  Waveform wave_;
  std::vector<std::optional<Value>> anchors_;  ///< the true value at which each piece began
  std::deque<TimedValue> truths_;              ///< true values of the last two seconds
  sim::Random noise_;
};

/// Range of the sizes of a channel's pieces.
struct Sizes {
  double min = 0.0;  ///< of bias, swing and noise, and of drift per second
  double max = 0.0;
  int width = 3;  ///< how many of the three numbers the channel has
};

/// Draws a waveform of one to three pieces that begin within `within_s` of the course's beginning.
Waveform drawn_wave(const Sizes& sizes, double earliest_s, double within_s, sim::Random& random);
/// Draws a neighbour of a waveform: one piece is changed slightly, drawn again, added or removed.
Waveform neighbour_of(const Waveform& wave, const Sizes& sizes, double earliest_s, double within_s,
                      sim::Random& random);

}  // namespace m100::scenario
