// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/data/unit_consistency.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "host_tests/lab/identify/data/log_defects.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::identify {
namespace {

using logs::FlightLog;
using logs::Signal;

constexpr double kWindow_s = 1.0;
constexpr std::size_t kMinWindows = 12;
constexpr std::size_t kGroups = 12;
constexpr double kSigmas = 3.0;
constexpr double kMinCommon = 0.5;       // shared part of the variance
constexpr double kSmallestUnit = 0.332;  // -0.5 ln 0.514: half of the way from 1 m/s to a knot, in logarithms
constexpr double kFreeFalls = 2.0;
constexpr double kStandardGravity_m_s2 = 9.80665;

/// A signal and its derivative.
struct SignalPair {
  const char* axis;
  Signal value;
  Signal slope;
};
constexpr std::array kSignalPairs{SignalPair{"roll", Signal::kAttitudeRoll, Signal::kRateX},
                                  SignalPair{"pitch", Signal::kAttitudePitch, Signal::kRateY},
                                  SignalPair{"yaw_rate", Signal::kAttitudeYaw, Signal::kRateZ},
                                  SignalPair{"climb", Signal::kPositionZ, Signal::kVelocityZ},
                                  SignalPair{"climb", Signal::kVelocityZ, Signal::kForceZ},
                                  SignalPair{"translation", Signal::kAttitudeRoll, Signal::kRateX},
                                  SignalPair{"translation", Signal::kAttitudePitch, Signal::kRateY},
                                  SignalPair{"translation", Signal::kPositionX, Signal::kVelocityX},
                                  SignalPair{"translation", Signal::kPositionY, Signal::kVelocityY}};

/// Change of the value over each window, and the change that its derivative gives.
struct Windows {
  std::vector<double> changed;
  std::vector<double> from_slope;
};

Windows windows_of(const FlightLog& log, const std::vector<char>& wanted, const std::vector<std::uint8_t>& gap,
                   const std::vector<double>& value, const std::vector<double>& slope) {
  const auto length = static_cast<std::size_t>(std::lround(kWindow_s / log.period_s));
  Windows out;
  double sum = 0.0;
  std::size_t count = 0;  // consecutive usable samples
  for (std::size_t i = 0; i + 1 < log.size; ++i) {
    const bool usable = wanted[i] != 0 && (i >= gap.size() || gap[i] == 0);
    sum = usable ? sum + 0.5 * (slope[i] + slope[i + 1]) * log.period_s : 0.0;
    count = usable ? count + 1 : 0;
    if (count == length) {
      out.changed.push_back(value[i + 1] - value[i + 1 - length]);
      out.from_slope.push_back(sum);
      sum = 0.0;
      count = 0;
    }
  }
  return out;
}

/// Logarithms of the two regressions that bound the factor from `from_slope` to `changed`.
struct Factor {
  double low = 0.0;
  double high = 0.0;
  double common = 0.0;  ///< share of the variance
};

/// @param left_out  group of windows that is left out; kGroups: none
std::optional<Factor> factor_of(const Windows& windows, std::size_t left_out) {
  const std::size_t size = windows.changed.size();
  std::array<double, 6> sums{};  // n, x, y, xx, yy, xy
  for (std::size_t k = 0; k < size; ++k) {
    if (k * kGroups / size == left_out) {
      continue;
    }
    const double x = windows.from_slope[k];
    const double y = windows.changed[k];
    const std::array<double, 6> more{1.0, x, y, x * x, y * y, x * y};
    std::transform(sums.begin(), sums.end(), more.begin(), sums.begin(), std::plus<>());
  }
  const auto [n, x, y, xx, yy, xy] = sums;
  const double own = xx - x * x / n;
  const double other = yy - y * y / n;
  const double both = std::abs(xy - x * y / n);
  if (!(own > 0.0 && other > 0.0 && both > 0.0)) {
    return std::nullopt;
  }
  return Factor{std::log(both / own), std::log(other / both), both * both / (own * other)};
}

/// The factor from `from_slope` to `changed`, if its logarithm is certainly larger than kSmallestUnit in size.
std::optional<double> contradiction(const Windows& windows) {
  if (windows.changed.size() < kMinWindows) {
    return std::nullopt;
  }
  const std::optional<Factor> all = factor_of(windows, kGroups);
  if (!all || all->common < kMinCommon) {
    return std::nullopt;
  }
  double low_square = 0.0;
  double high_square = 0.0;
  for (std::size_t group = 0; group < kGroups; ++group) {
    const std::optional<Factor> without = factor_of(windows, group);
    if (!without) {
      return std::nullopt;
    }
    low_square += (without->low - all->low) * (without->low - all->low);
    high_square += (without->high - all->high) * (without->high - all->high);
  }
  constexpr double kJackknife = (kGroups - 1.0) / kGroups;
  const double low = all->low - kSigmas * std::sqrt(kJackknife * low_square);
  const double high = all->high + kSigmas * std::sqrt(kJackknife * high_square);
  if (low < kSmallestUnit && high > -kSmallestUnit) {
    return std::nullopt;
  }
  return std::exp(0.5 * (all->low + all->high));
}

std::string unit_of(double factor) {
  struct Name {
    double factor;
    const char* text;
  };
  constexpr std::array kNames{Name{180.0 / std::numbers::pi, "degrees"},
                              Name{100.0, "centimetres"},
                              Name{1.0 / 0.3048, "feet"},
                              Name{1000.0, "thousandths"},
                              Name{1.0 / 0.514444, "knots"},
                              Name{3.6, "kilometres per hour"},
                              Name{9.80665, "multiples of g"}};
  const double size = std::abs(std::log(factor));
  for (const Name& name : kNames) {
    if (std::abs(size - std::log(name.factor)) < 0.05) {
      return std::string("one of them is probably in ") + name.text;
    }
  }
  return "the unit of one of them is wrong";
}

/// Acceleration upwards [m/s^2] from the specific force. Without a logged attitude the vehicle is taken as level.
std::vector<double> upward(const FlightLog& log) {
  std::vector<double> out = log.of(Signal::kForceZ);
  if (log.has3(Signal::kForceX) && log.has(Signal::kAttitudeRoll) && log.has(Signal::kAttitudePitch)) {
    for (std::size_t i = 0; i < log.size; ++i) {
      const double roll = log.of(Signal::kAttitudeRoll)[i];
      const double pitch = log.of(Signal::kAttitudePitch)[i];
      out[i] = std::cos(pitch) * (std::cos(roll) * out[i] + std::sin(roll) * log.of(Signal::kForceY)[i]) -
               std::sin(pitch) * log.of(Signal::kForceX)[i];
    }
  }
  for (double& value : out) {
    value -= kStandardGravity_m_s2;
  }
  return out;
}

/// A finding if velocity_z falls at more than 2 g over half a second. A rotor cannot push down, so no vehicle falls
/// faster than at g; the rest is a margin for noise.
std::vector<Finding> falls(const FlightLog& log, const std::vector<char>& wanted) {
  const auto half = static_cast<std::size_t>(std::lround(0.5 * kWindow_s / log.period_s));
  const std::vector<double>& speed = log.of(Signal::kVelocityZ);
  const std::vector<std::uint8_t> gap = log.gap_of({Signal::kVelocityZ});
  std::vector<double> downwards;
  for (std::size_t i = half; i < log.size; i += std::max<std::size_t>(1, half / 5)) {
    if (wanted[i] != 0 && wanted[i - half] != 0 && (gap.empty() || (gap[i] == 0 && gap[i - half] == 0))) {
      downwards.push_back((speed[i - half] - speed[i]) / (0.5 * kWindow_s));
    }
  }
  if (downwards.size() < kMinWindows) {
    return {};
  }
  // A quantile instead of the maximum: a spoilt sample is no fall.
  const auto at = downwards.end() - 1 - static_cast<std::ptrdiff_t>(downwards.size() / 50);
  std::nth_element(downwards.begin(), at, downwards.end());
  if (*at < kFreeFalls * kStandardGravity_m_s2) {
    return {};
  }
  const std::string text = printed(
      "velocity_z falls by %.0f m/s in half a second, much faster than free fall: is it in centimetres or feet?",
      0.5 * kWindow_s * *at);
  return {{.what = "wrong_unit", .signal = "velocity_z", .text = text}};
}

}  // namespace

std::vector<Finding> unit_contradictions(const FlightLog& log, const std::string& axis,
                                         const std::vector<Range>& requested) {
  const std::vector<char> wanted = mask_ranges(log, requested, 0.0);
  std::vector<Finding> out;
  for (const SignalPair& witness : kSignalPairs) {
    if (axis != witness.axis || !log.has(witness.value) || !log.has(witness.slope)) {
      continue;
    }
    const bool force = witness.slope == Signal::kForceZ;
    const std::optional<double> factor =
        contradiction(windows_of(log, wanted, log.gap_of({witness.value, witness.slope}), log.of(witness.value),
                                 force ? upward(log) : log.of(witness.slope)));
    if (!factor) {
      continue;
    }
    const std::string value(logs::name_of(witness.value));
    const std::string slope(logs::name_of(witness.slope));
    const std::string text = printed("%s changes %.3g times as fast as %s shows: %s", value.c_str(), *factor,
                                     slope.c_str(), unit_of(*factor).c_str());
    out.push_back({.what = "wrong_unit", .signal = axis == "climb" ? "velocity_z" : value, .text = text});
  }
  if (out.empty() && axis == "climb" && log.has(Signal::kVelocityZ)) {
    out = falls(log, wanted);
  }
  return out;
}

}  // namespace m100::lab::identify
